#define QUERN_ISA avx512
#include "src/contact/kernels_isa.inl"
