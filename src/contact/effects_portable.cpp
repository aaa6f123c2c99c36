#define QUERN_ISA portable
#include "src/contact/effects_isa.inl"
