// The documents that go to and come from one other player, part by part, about one tick.
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
  /// The document that goes to the other.
  void offer(Document document, Bytes bytes);
  bool is_offered(Document document) const { return side(document).is_offered; }
  /// The other's document; null: not all of it is here.
  const Bytes* arrived(Document document) const {
    return side(document).received.is_whole ? &side(document).in : nullptr;
  }

  /// Whether the other lacks a part, or waits for an answer.
  bool has_message() const;
  /// Fills what the message says of documents. `size`: room for the part.
  void next(std::size_t size, Message& message);
  /// Errors: corrupt (a part that does not belong to the document that began).
  Status take(const Message& message);
  void owe_answer() { owes_answer_ = true; }

 private:
  struct Side {
    Bytes out;
    bool is_offered = false;
    std::uint32_t out_next = 0;  // first byte of the next part
    Received confirmed;          // what the other has of it
    Bytes in;
    std::uint32_t in_size = 0;  // of the whole document; known with the first part
    Received received;
  };
  const Side& side(Document document) const { return sides_[static_cast<std::size_t>(document) - 1]; }
  Side& side(Document document) { return sides_[static_cast<std::size_t>(document) - 1]; }

  std::array<Side, document_count> sides_;
  bool owes_answer_ = false;
};

}  // namespace ticktrue::capi
