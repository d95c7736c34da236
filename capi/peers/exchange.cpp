// Sends each document from the first byte that the other player lacks, and assembles received parts.
// SPDX-License-Identifier: MIT
#include "capi/peers/exchange.h"

#include <algorithm>
#include <string>
#include <utility>

namespace ticktrue::capi {

void Exchange::offer(Document document, Bytes bytes) {
  Side& to = side(document);
  to.out = std::move(bytes);
  to.is_offered = true;
}

bool Exchange::has_message() const {
  if (owes_answer_) return true;
  return std::any_of(sides_.begin(), sides_.end(),
                     [](const Side& side) { return side.is_offered && !side.confirmed.is_whole; });
}

void Exchange::next(std::size_t size, Message& message) {
  owes_answer_ = false;
  for (std::size_t i = 0; i < document_count; ++i) message.received[i] = sides_[i].received;
  for (std::size_t i = 0; i < document_count; ++i) {
    Side& to = sides_[i];
    if (!to.is_offered || to.confirmed.is_whole) continue;
    if (to.out_next >= to.out.size() || to.out_next < to.confirmed.size) to.out_next = to.confirmed.size;
    message.document = static_cast<Document>(i + 1);
    message.document_size = static_cast<std::uint32_t>(to.out.size());
    message.offset = to.out_next;
    message.part = ByteView(to.out).subspan(to.out_next).first(std::min(size, to.out.size() - to.out_next));
    to.out_next += static_cast<std::uint32_t>(message.part.size());
    return;
  }
}

Status Exchange::take(const Message& message) {
  for (std::size_t i = 0; i < document_count; ++i) {
    Side& to = sides_[i];
    const Received& received = message.received[i];
    if (received.size > to.out.size() || (received.is_whole && (!to.is_offered || received.size != to.out.size())))
      return Error{ErrorCode::corrupt,
                   "desync message: received: found " + std::to_string(received.size) + " bytes, expected at most " +
                       std::to_string(to.out.size()),
                   ""};
  }
  if (message.document != Document::none) {
    const Side& from = side(message.document);
    if ((from.received.size > 0 || from.received.is_whole) && from.in_size != message.document_size)
      return Error{ErrorCode::corrupt,
                   "desync message: document: found " + std::to_string(message.document_size) + " bytes, expected " +
                       std::to_string(from.in_size) + " as before",
                   ""};
  }
  for (std::size_t i = 0; i < document_count; ++i) {
    Received& confirmed = sides_[i].confirmed;
    if (message.received[i].is_whole) confirmed.is_whole = true;
    confirmed.size = std::max(confirmed.size, message.received[i].size);
  }
  if (message.document == Document::none) return {};
  Side& from = side(message.document);
  owes_answer_ = true;
  if (from.received.is_whole || message.offset > from.received.size) return {};  // known, or an earlier part was lost
  from.in_size = message.document_size;
  const std::size_t known = from.received.size - message.offset;
  if (known >= message.part.size()) return {};
  const ByteView more = message.part.subspan(known);
  from.in.insert(from.in.end(), more.begin(), more.end());
  from.received.size += static_cast<std::uint32_t>(more.size());
  from.received.is_whole = from.received.size == from.in_size;
  return {};
}

}  // namespace ticktrue::capi
