#include "sim/method.inl.h"

namespace firn {

template class Method<float, Weights::cubic, Transfer::flip>;
template class Method<float, Weights::cubic, Transfer::apic>;
template class Method<float, Weights::quadratic, Transfer::flip>;
template class Method<float, Weights::quadratic, Transfer::apic>;

}  // namespace firn
