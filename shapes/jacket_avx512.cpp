#define QUERN_ISA avx512
#include "shapes/jacket_isa.inl"
