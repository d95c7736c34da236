// The documents that two players exchange about one tick, part by part.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/bytes.h"
#include "base/result.h"
#include "capi/peers/message.h"

namespace ticktrue::capi {

class Exchange {
 public:
  /// Sets the document to send.
  void offer(Document document, Bytes bytes);
  bool is_offered(Document document) const { return side(document).is_offered; }
  /// The document of the other player; null: incomplete.
  const Bytes* arrived(Document document) const {
    return side(document).received.is_whole ? &side(document).in : nullptr;
  }

  /// Whether the other player lacks a part, or waits for an answer.
  bool has_message() const;
  /// Fills the fields of the message about documents. `size`: capacity of the part.
  void next(std::size_t size, Message& message);
  /// Errors: corrupt (a part that does not fit to the earlier parts of the document).
  Status take(const Message& message);
  void owe_answer() { owes_answer_ = true; }

 private:
  struct Side {
    Bytes out;
    bool is_offered = false;
    std::uint32_t out_next = 0;  // offset of the next part
    Received confirmed;          // bytes that the other player has
    Bytes in;
    std::uint32_t in_size = 0;  // of the whole document; known from the first part on
    Received received;
  };
  const Side& side(Document document) const { return sides_[static_cast<std::size_t>(document) - 1]; }
  Side& side(Document document) { return sides_[static_cast<std::size_t>(document) - 1]; }

  std::array<Side, document_count> sides_;
  bool owes_answer_ = false;
};

}  // namespace ticktrue::capi
