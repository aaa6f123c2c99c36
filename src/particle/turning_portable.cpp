#define QUERN_ISA portable
#include "src/particle/turning_isa.inl"
