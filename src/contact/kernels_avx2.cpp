#define QUERN_ISA avx2
#include "src/contact/kernels_isa.inl"
