#define QUERN_ISA avx2
#include "src/contact/shape_meeting_isa.inl"
