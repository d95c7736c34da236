// Searches over single bits: each candidate rehashes one block; the hashes of the other blocks are reused.
// SPDX-License-Identifier: MIT
#include "verifier/verify/single_change.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include "base/hash.h"
#include "base/parallel/jobs.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t hash_block_size = 16 * 1024;  // bytes of rows; docs/trace_format.md, "Root hash"

/// A block of rows in one table, and the place of its hash in the digest behind the root hash.
struct Block {
  std::size_t offset = 0;  // in the image
  std::size_t size = 0;
  std::size_t digest_offset = 0;
};

struct HashTree {
  std::vector<Block> blocks;
  Bytes digest;  // docs/trace_format.md, "Root hash"
};

HashTree make_tree(const StateSchema& schema, ByteView image, const std::vector<ImageTable>& tables) {
  HashTree tree;
  ByteWriter digest;
  for (std::size_t t = 0; t < tables.size(); ++t) {
    const std::string& name = schema.tables[t].name;
    const ByteView rows = tables[t].rows;
    digest.u64(hash64({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()}));
    digest.u64(tables[t].row_count);
    for (std::size_t offset = 0; offset < rows.size(); offset += hash_block_size) {
      const std::size_t size = std::min(hash_block_size, rows.size() - offset);
      tree.blocks.push_back(
          {static_cast<std::size_t>(rows.data() - image.data()) + offset, size, digest.view().size()});
      digest.u64(hash64(rows.subspan(offset, size)));
    }
  }
  tree.digest = digest.take();
  return tree;
}

/// Byte and bit of the block whose flip gives the wanted root hash.
struct FoundBit {
  std::size_t byte = 0;
  int bit = 0;
};
std::optional<FoundBit> search_block(const HashTree& tree, const Block& block, ByteView image, std::uint64_t wanted) {
  const ByteView original = image.subspan(block.offset, block.size);
  Bytes changed(original.begin(), original.end());
  Bytes digest = tree.digest;
  for (std::size_t byte = 0; byte < changed.size(); ++byte)
    for (int bit = 0; bit < 8; ++bit) {
      changed[byte] = static_cast<std::uint8_t>(original[byte] ^ (1u << bit));
      const std::uint64_t hash = hash64(changed);
      for (std::size_t i = 0; i < 8; ++i) digest[block.digest_offset + i] = static_cast<std::uint8_t>(hash >> (8 * i));
      if (hash64(digest) == wanted) return FoundBit{byte, bit};
      changed[byte] = original[byte];
    }
  return std::nullopt;
}

}  // namespace

Result<std::optional<Bytes>> find_single_bit(const StateSchema& schema, ByteView image, std::uint64_t wanted,
                                             unsigned thread_count) {
  const auto tables = split_image(schema, image);
  if (!tables) return tables.error();
  if (image.size() * 8 > single_changes_max) return std::optional<Bytes>();
  const HashTree tree = make_tree(schema, image, *tables);
  std::vector<std::optional<FoundBit>> found(tree.blocks.size());
  std::atomic<bool> is_found{false};
  const Status status = run_jobs(tree.blocks.size(), thread_count, [&](std::size_t i) {
    if (is_found) return;
    found[i] = search_block(tree, tree.blocks[i], image, wanted);
    if (found[i]) is_found = true;
  });
  if (!status) return status.error();
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    Bytes right(image.begin(), image.end());
    std::uint8_t& byte = right[tree.blocks[i].offset + found[i]->byte];
    byte = static_cast<std::uint8_t>(byte ^ (1u << found[i]->bit));
    return std::optional<Bytes>(std::move(right));
  }
  return std::optional<Bytes>();
}

void explain_by_single_bit(const WalkContext& context, const Mismatch& mismatch, Findings& findings) {
  const bool is_open = findings.verdict == Verdict::diverged && findings.divergence->rows.empty();
  if (!is_open || mismatch.part != TickPart::root_hash || mismatch.expected.image) return;
  const auto recorded =
      find_single_bit(context.setup.schema, mismatch.got, mismatch.expected.root_hash, context.options.thread_count);
  if (!recorded || !*recorded) return;
  const auto simulation = make_simulation(context, findings);
  if (simulation == nullptr) return;
  const bool has_names = simulation->load(mismatch.got).has_value();
  Findings named;
  describe_lanes(context, *simulation, **recorded, mismatch.got, *findings.divergence, named);
  if (!has_names)
    for (LaneReport& row : findings.divergence->rows) row.name.clear();
  findings.divergence->stage_note = "after the last one, or in what no later stage of the tick reads";
  findings.notes.push_back(
      "one bit: of all states that differ from the one here in a single bit, this one has the recorded hash");
  findings.hint = "a single bit is what failing memory and stray writes change: test the recording machine";
}

}  // namespace ticktrue::verifier
