// Computes the identity of a session from a setup of any format version.
// SPDX-License-Identifier: MIT
#include "replay/format/identity.h"

#include <limits>

#include "base/hash.h"

namespace ticktrue::replay {

void encode_judged_schema(const StateSchema& schema, ByteWriter& out) {
  StateSchema judged = judged_schema(schema);
  for (TableSchema& table : judged.tables)
    for (Column& column : table.columns) {
      column.min = -std::numeric_limits<double>::infinity();
      column.max = std::numeric_limits<double>::infinity();
    }
  encode_schema(judged, out, SchemaLayout::third);
}

std::uint64_t session_identity(const TraceSetup& setup) {
  ByteWriter out;
  out.text(setup.simulation);
  out.u32(setup.physics_version);
  out.f64(setup.dt);
  encode_judged_schema(setup.whole_schema ? *setup.whole_schema : setup.schema, out);
  out.u32(static_cast<std::uint32_t>(setup.setup.size()));
  out.bytes(setup.setup);
  return hash64(out.view());
}

}  // namespace ticktrue::replay
