#define QUERN_ISA portable
#include "shapes/jacket_isa.inl"
