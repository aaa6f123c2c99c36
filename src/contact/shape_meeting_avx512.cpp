#define QUERN_ISA avx512
#include "src/contact/shape_meeting_isa.inl"
