#define QUERN_ISA avx2
#include "shapes/jacket_isa.inl"
