// Fuzzes what other players of a live game send: hellos, messages about a desync and the documents in them.
// SPDX-License-Identifier: MIT
//
// Input: a byte that says which, then the bytes. Of messages there are several, each behind its size of two bytes; as
// in a forgery with knowledge, the fields that name session, players and tick are made right, and so is the check.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "base/hash.h"
#include "capi/peers/message.h"
#include "capi/peers/peers.h"
#include "tests/fuzz/support/fuzz.h"
#include "tests/fuzz/support/peers_world.h"

namespace {

using namespace ticktrue;

constexpr std::size_t check_size = 8;
constexpr std::size_t fields_end = 28;  // of a message: behind magic, identity, from, to and tick

/// The same bytes with a right check.
Bytes sealed(Bytes bytes) {
  if (bytes.size() < check_size) return bytes;
  const std::uint64_t check = hash64(ByteView(bytes).first(bytes.size() - check_size));
  for (std::size_t i = 0; i < check_size; ++i)
    bytes[bytes.size() - check_size + i] = static_cast<std::uint8_t>(check >> (8 * i));
  return bytes;
}

void fuzz_hello(const Bytes& bytes) {
  const fuzz::PeersWorld world;
  for (const Bytes& one : {bytes, sealed(bytes)}) {
    const auto hello = capi::decode_hello(one);
    if (!hello) {
      fuzz::require_message(hello.error());
      continue;
    }
    fuzz::require(capi::decode_hello(capi::encode_hello(*hello)).has_value(), "a hello is read as it was written");
    const Bytes own_bytes = world.peers->hello();
    const auto own = capi::decode_hello(own_bytes);
    fuzz::require(own.has_value(), "the own hello is read");
    const capi::HelloDifferences differences = capi::hello_differences(*own, *hello);
    fuzz::require(own->identity == hello->identity || !differences.refusals.empty(), "another game is refused");
  }
}

void fuzz_documents(const Bytes& bytes) {
  const fuzz::PeersWorld world;
  if (const auto cells = capi::decode_cells_document(world.schema, bytes)) {
    ByteWriter again;
    capi::encode_cells_document(*cells, world.schema, again);
    fuzz::require(capi::decode_cells_document(world.schema, again.view()).has_value(), "cells are read again");
    if (cells->has_state) {
      CellHasher hasher(world.schema);
      const capi::RowsDocument rows = capi::rows_to_send(world.view(), cells->cells, hasher);
      ByteWriter out;
      capi::encode_rows_document(rows, out);
      fuzz::require(capi::decode_rows_document(world.schema, out.view()).has_value(), "own rows are read");
    }
  }
  if (const auto rows = capi::decode_rows_document(world.schema, bytes)) {
    const capi::OtherState other(world.view(), capi::RowsDocument(), *rows);
    fuzz::require(other.tables().size() == world.schema.tables.size(), "a state has all tables");
    Bytes buffer;
    const std::vector<ImageTable> own = canonical_tables(world.view(), buffer);
    capi::DesyncFinding finding;
    finding.simulation = "fuzz";
    for (const auto& tables : {std::span<const ImageTable>(own), other.tables()}) {
      capi::DesyncPlayer& player = finding.players.emplace_back();
      player.player = static_cast<std::uint32_t>(finding.players.size());
      player.root = player.player;
      player.tables.emplace(tables.begin(), tables.end());
    }
    verifier::compare_players(world.schema, {}, finding);
    fuzz::require(!capi::desync_text(world.schema, finding).empty(), "two states have a text");
    fuzz::require(!capi::desync_json(world.schema, finding).empty(), "two states have an object");
  }
}

void fuzz_messages(const Bytes& bytes) {
  const fuzz::PeersWorld world;
  const Bytes fields = world.fields();
  ByteReader in(bytes);
  while (in.ok() && !in.at_end()) {
    const ByteView part = in.bytes(std::min<std::size_t>(in.u16(), in.remaining()));
    Bytes message(part.begin(), part.end());
    if (message.size() >= fields_end) std::copy_n(fields.begin(), fields_end, message.begin());
    const Status status = world.peers->receive(1, sealed(message));
    if (!status) fuzz::require_message(status.error());
    world.peers->next_message(1, 300);
    if (world.peers->has_desync()) {
      const capi::DesyncFinding finding = world.peers->finding({});
      fuzz::require(!capi::desync_text(world.schema, finding).empty(), "a desync has a text");
      fuzz::require(!capi::desync_json(world.schema, finding).empty(), "a desync has an object");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Bytes bytes(data + 1, data + size);
  switch (data[0] % 3) {
    case 0:
      fuzz_hello(bytes);
      break;
    case 1:
      fuzz_documents(bytes);
      break;
    default:
      fuzz_messages(bytes);
  }
  return 0;
}
