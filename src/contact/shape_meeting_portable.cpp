#define QUERN_ISA portable
#include "src/contact/shape_meeting_isa.inl"
