#define QUERN_ISA avx512
#include "src/particle/turning_isa.inl"
