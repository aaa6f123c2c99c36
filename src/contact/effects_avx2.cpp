#define QUERN_ISA avx2
#include "src/contact/effects_isa.inl"
