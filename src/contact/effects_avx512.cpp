#define QUERN_ISA avx512
#include "src/contact/effects_isa.inl"
