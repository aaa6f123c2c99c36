#define QUERN_ISA avx2
#include "src/particle/turning_isa.inl"
