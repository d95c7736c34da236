// A plug-in with child tables: squads with a name, a flag and a list of members, each of which has a label.
// SPDX-License-Identifier: MIT
//
// CHILD_PLUGIN=FAULT makes it misbehave; see plugin_children_test.cpp.
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "include/ticktrue.h"

namespace {

bool has(const char* fault) {
  const char* asked = std::getenv("CHILD_PLUGIN");
  return asked != nullptr && std::strcmp(asked, fault) == 0;
}

struct Member {
  std::uint16_t rank;
  std::string label;
};
struct Squad {
  std::uint32_t id;
  float morale;
  std::string name;
  std::vector<std::uint8_t> flag;
  std::vector<Member> members;
};
struct Camp {
  std::uint64_t tick = 0;
  std::vector<Squad> squads;
};

int create(const ticktrue_host*, const void*, std::size_t, void** simulation, char*, std::size_t) {
  auto* camp = new Camp;
  for (std::uint32_t id : {2u, 5u, 6u}) camp->squads.push_back({id, 0.5f, "squad " + std::to_string(id), {}, {}});
  *simulation = camp;
  return 0;
}

void destroy(void* simulation) {
  delete static_cast<Camp*>(simulation);
}

template <typename List>
const void* first_of(const List& list, std::size_t* count) {
  *count = list.size();
  return list.data();
}
const void* name_of(void* user, const void* owner, std::uint32_t, std::size_t* count) {
  if (has("crash") && static_cast<Camp*>(user)->tick == 7) ::raise(SIGSEGV);
  return first_of(static_cast<const Squad*>(owner)->name, count);
}
const void* flag_of(void*, const void* owner, std::uint32_t, std::size_t* count) {
  const void* first = first_of(static_cast<const Squad*>(owner)->flag, count);
  return has("null") && *count > 3 ? nullptr : first;
}
const void* members_of(void*, const void* owner, std::uint32_t, std::size_t* count) {
  return first_of(static_cast<const Squad*>(owner)->members, count);
}
const void* label_of(void*, const void* owner, std::uint32_t, std::size_t* count) {
  return first_of(static_cast<const Member*>(owner)->label, count);
}

int columns(void* simulation, const ticktrue_host* host, ticktrue_columns* out) {
  auto* camp = static_cast<Camp*>(simulation);
  const int morale = has("shown") ? TICKTRUE_F32 | TICKTRUE_SHOWN : TICKTRUE_F32;
  const ticktrue_member squad[] = {TICKTRUE_MEMBER(Squad, id, TICKTRUE_U32), TICKTRUE_MEMBER(Squad, morale, morale)};
  const ticktrue_member member[] = {TICKTRUE_MEMBER(Member, rank, has("type") ? TICKTRUE_F64 : TICKTRUE_U16)};
  host->column(out, "world", "tick", &camp->tick, TICKTRUE_U64, 1, 1, 0);
  const std::uint32_t table = host->table(out, "squads", sizeof(Squad), squad, 2);
  host->key(out, "squads", 1);
  host->rows(out, table, camp->squads.data(), static_cast<std::uint32_t>(camp->squads.size()));
  host->text(out, "squads.name", has("orphan") ? "camps" : "squads", name_of, camp);
  host->bytes(out, "squads.flag", "squads", flag_of, nullptr);
  host->child(out, "squads.members", "squads", members_of, nullptr, sizeof(Member), member, 1);
  return host->text(out, "squads.members.label", "squads.members", label_of, nullptr);
}

int step(void* simulation, double, const void*, std::size_t, const ticktrue_host*, ticktrue_stages*, char*,
         std::size_t) {
  auto* camp = static_cast<Camp*>(simulation);
  const auto tick = static_cast<std::uint32_t>(camp->tick);
  for (Squad& squad : camp->squads) {
    squad.morale = squad.morale * 0.75f + static_cast<float>(squad.id % 3);
    squad.flag.assign((tick + squad.id) % 300, static_cast<std::uint8_t>(tick));
    if ((tick + squad.id) % 5 == 0) squad.members.push_back({static_cast<std::uint16_t>(tick), "recruit of tick "});
    if (squad.members.size() > 6) squad.members.erase(squad.members.begin());
    for (Member& member : squad.members)
      if (member.rank % 3 == tick % 3) member.label += std::to_string(tick % 10);
  }
  if (tick % 20 == 19) camp->squads.push_back({tick, 1, "squad of tick " + std::to_string(tick), {}, {}});
  if (tick == 25) camp->squads[1].name += has("other") ? " the Brave" : " the Bold";
  ++camp->tick;
  return 0;
}

/// The save: numbers and texts one after the other, each text behind its size.
void put(std::vector<std::uint8_t>& out, const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  out.insert(out.end(), bytes, bytes + size);
}
template <typename Value>
void put_value(std::vector<std::uint8_t>& out, Value value) {
  put(out, &value, sizeof value);
}
template <typename List>
void put_list(std::vector<std::uint8_t>& out, const List& list) {
  put_value(out, static_cast<std::uint32_t>(list.size()));
  put(out, list.data(), list.size());
}
struct Save {
  const std::uint8_t* at;
  std::size_t left;
  bool ok = true;

  template <typename Value>
  Value value() {
    Value read{};
    if (left < sizeof read) ok = false;
    if (!ok) return {};
    std::memcpy(&read, at, sizeof read);
    at += sizeof read;
    left -= sizeof read;
    return read;
  }
  template <typename List>
  List list() {
    const std::size_t size = value<std::uint32_t>();
    if (size > left) ok = false;
    if (!ok) return {};
    const auto* first = reinterpret_cast<const typename List::value_type*>(at);
    at += size;
    left -= size;
    return List(first, first + size);
  }
};

std::size_t save(void* simulation, void* buffer, std::size_t size) {
  const auto* camp = static_cast<const Camp*>(simulation);
  std::vector<std::uint8_t> out;
  put_value(out, camp->tick);
  put_value(out, static_cast<std::uint32_t>(camp->squads.size()));
  for (const Squad& squad : camp->squads) {
    put_value(out, squad.id);
    put_value(out, squad.morale);
    put_list(out, squad.name);
    put_list(out, squad.flag);
    put_value(out, static_cast<std::uint32_t>(squad.members.size()));
    for (const Member& member : squad.members) {
      put_value(out, member.rank);
      put_list(out, member.label);
    }
  }
  if (out.size() <= size) std::memcpy(buffer, out.data(), out.size());
  return out.size();
}

int load(void* simulation, const void* bytes, std::size_t size) {
  Save in{static_cast<const std::uint8_t*>(bytes), size};
  Camp camp;
  camp.tick = in.value<std::uint64_t>();
  const auto squad_count = in.value<std::uint32_t>();
  for (std::uint32_t s = 0; s < squad_count && in.ok; ++s) {
    Squad& squad = camp.squads.emplace_back();
    squad.id = in.value<std::uint32_t>();
    squad.morale = in.value<float>();
    squad.name = in.list<std::string>();
    squad.flag = in.list<std::vector<std::uint8_t>>();
    const auto member_count = in.value<std::uint32_t>();
    for (std::uint32_t m = 0; m < member_count && in.ok; ++m) {
      const auto rank = in.value<std::uint16_t>();
      squad.members.push_back({rank, in.list<std::string>()});
    }
    if (has("forgets") && s == 1) squad.name = "squad 5";
  }
  if (!in.ok || in.left > 0) return 1;
  *static_cast<Camp*>(simulation) = camp;
  return 0;
}

/// For traces without saves: columns alone come back by it.
int loaded(void*, char*, std::size_t) {
  return 0;
}

}  // namespace

extern "C" TICKTRUE_PLUGIN_API const ticktrue_plugin* ticktrue_plugin_entry(std::uint32_t) {
  static ticktrue_plugin plugin;
  plugin.struct_size = sizeof plugin;
  plugin.api_version = TICKTRUE_API_VERSION;
  plugin.name = "child-plugin";
  plugin.create = create;
  plugin.destroy = destroy;
  plugin.columns = columns;
  plugin.step = step;
  plugin.loaded = loaded;
  plugin.save = has("no saves") ? nullptr : save;
  plugin.load = has("no saves") ? nullptr : load;
  return &plugin;
}
