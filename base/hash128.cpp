// XXH3-128 by the kernels of this machine.
// SPDX-License-Identifier: MIT
#include "base/hash128.h"

#include "base/hash.h"
#include "base/row_kernels.h"

namespace ticktrue {

Hash128 hash128(ByteView bytes) {
  Hash128Stream stream;
  stream.add(bytes);
  return stream.value();
}

Hash128Stream::Hash128Stream() {
  row_kernels().start128(state_.data(), state_.size());
}

void Hash128Stream::add(ByteView bytes) {
  row_kernels().add128(state_.data(), bytes.data(), bytes.size());
}

Hash128 Hash128Stream::value() const {
  Hash128 value;
  row_kernels().value128(state_.data(), &value.high, &value.low);
  return value;
}

std::string hex128(const Hash128& value) {
  return hex64(value.high) + hex64(value.low);
}

}  // namespace ticktrue
