#include "sim/method.inl.h"

namespace firn {

template class Method<double, Weights::cubic, Transfer::flip>;
template class Method<double, Weights::cubic, Transfer::apic>;
template class Method<double, Weights::quadratic, Transfer::flip>;
template class Method<double, Weights::quadratic, Transfer::apic>;

}  // namespace firn
