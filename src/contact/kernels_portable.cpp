#define QUERN_ISA portable
#include "src/contact/kernels_isa.inl"
