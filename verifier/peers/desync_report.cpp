// Compares the states of all players, and prints the differences.
// SPDX-License-Identifier: MIT
#include "verifier/peers/desync_report.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <tuple>
#include <utility>

#include "base/count_text.h"
#include "base/hash.h"
#include "base/plain_text.h"
#include "base/state/child_tables.h"
#include "verifier/report/content_text.h"
#include "verifier/report/fact_differences.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t compared_lane_count_max = 100'000;  // between two players
constexpr std::size_t lane_shown_max = 8;
constexpr std::size_t content_shown_max = 8;

/// The order of the report. Rows that the first state lacks come after its own rows with the same number.
using LaneKey = std::tuple<std::size_t, std::size_t, bool, std::uint64_t, std::size_t, std::size_t>;

LaneKey lane_key(const LaneDifference& lane) {
  return {lane.place.table,    lane.place.row,    !lane.expected.has_value(),
          lane.id.value_or(0), lane.place.column, lane.place.lane};
}

using replay::TickInputs;
using Names = std::vector<std::size_t>;  // indices into the list of players

/// "player 0", "players 0, 2".
std::string players_text(const DesyncFinding& finding, const Names& names) {
  std::string text = names.size() == 1 ? "player " : "players ";
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(finding.players[names[i]].player);
  return text;
}

/// "players 0, 2: A.  player 1: B". Players without a value are in no group.
template <typename Value, typename Text>
std::string grouped(const DesyncFinding& finding, const std::vector<std::optional<Value>>& values, Text text_of) {
  std::vector<std::pair<Value, Names>> groups;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) continue;
    const auto found =
        std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.first == *values[i]; });
    if (found == groups.end())
      groups.push_back({*values[i], {i}});
    else
      found->second.push_back(i);
  }
  std::string text;
  for (const auto& [value, names] : groups)
    text += (text.empty() ? "" : ".  ") + players_text(finding, names) + ": " + text_of(value);
  return text;
}

void add_line(std::string& text, std::string label, const std::string& content) {
  if (label.size() < 7) label.resize(7, ' ');
  text += "  " + label + " " + plain_line(content) + "\n";
}

std::string row_text(const Column& column, const DesyncLane& lane) {
  std::string text = lane.where.empty() ? "row " + std::to_string(lane.place.row) : lane.where;
  const bool has_id = lane.id && lane.where.empty();  // that of an element is its owner, which the place has
  if (has_id || !lane.name.empty()) {
    text += " (";
    if (has_id) text += "id " + std::to_string(*lane.id);
    if (has_id && !lane.name.empty()) text += ", ";
    if (!lane.name.empty()) text += "name \"" + lane.name + "\"";
    text += ")";
  }
  if (column.lane_count > 1) text += ", lane " + std::to_string(lane.place.lane);
  return text;
}

/// A value; nothing: the row does not exist. Compared as a whole.
using ShownValue = std::optional<std::uint64_t>;

std::string values_text(const DesyncFinding& finding, const Column& column, const DesyncLane& lane) {
  std::vector<std::optional<ShownValue>> values;
  std::vector<std::uint64_t> bits;
  for (std::size_t i = 0; i < finding.players.size(); ++i) {
    values.emplace_back(finding.players[i].tables ? std::optional(lane.values[i]) : std::nullopt);
    if (finding.players[i].tables && lane.values[i] &&
        std::find(bits.begin(), bits.end(), *lane.values[i]) == bits.end())
      bits.push_back(*lane.values[i]);
  }
  std::string text = grouped(finding, values, [&](const ShownValue& value) {
    return value ? lane_hex(column.type, *value) + " (" + lane_text(column.type, *value) + ")"
                 : std::string("no such row");
  });
  if (bits.size() == 2)
    if (const auto ulp = ulp_distance(column.type, bits[0], bits[1])) text += ".  " + std::to_string(*ulp) + " ulp";
  return text;
}

/// The sides of the players whose states are known; a side of nothing is no such row.
using ShownSide = std::optional<ContentSide>;

std::vector<std::optional<ShownSide>> known_sides(const DesyncFinding& finding, const DesyncContent& content) {
  std::vector<std::optional<ShownSide>> sides;
  for (std::size_t i = 0; i < finding.players.size(); ++i)
    sides.push_back(finding.players[i].tables ? std::optional(content.sides[i]) : std::nullopt);
  return sides;
}

std::string contents_text(const DesyncFinding& finding, const DesyncContent& content) {
  const ContentDifference& what = content.what;
  const std::vector<std::optional<ShownSide>> sides = known_sides(finding, content);
  std::string text = grouped(
      finding, sides, [&](const ShownSide& side) { return content_side(what.is_text, what.first, what.offset, side); });
  text += what.character ? ".  differs at character " + std::to_string(*what.character)
                         : ".  differs at byte " + std::to_string(what.offset);
  std::vector<std::uint64_t> sizes;
  for (const std::optional<ShownSide>& side : sides)
    if (side && *side && std::find(sizes.begin(), sizes.end(), (*side)->size) == sizes.end())
      sizes.push_back((*side)->size);
  if (sizes.size() == 2) text += "; " + std::to_string(sizes[0]) + " and " + std::to_string(sizes[1]) + " bytes";
  if (sizes.size() == 1 && !what.is_text) text += " of " + std::to_string(sizes[0]);
  return text;
}

/// "9 values and 1 text".
std::string difference_count_text(const DesyncFinding& finding) {
  std::string text;
  if (finding.lane_count > 0 || finding.content_count == 0) text = count_text(finding.lane_count, "value");
  if (finding.content_count > 0) text += (text.empty() ? "" : " and ") + count_text(finding.content_count, "text");
  return text;
}

std::string inputs_text(const TickInputs& inputs, bool with_dt) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : inputs.begin) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  if (inputs.size > inputs.begin.size()) text += "... (" + std::to_string(inputs.size) + " bytes)";
  if (text.empty()) text = "none";
  if (with_dt) text += ", dt " + lane_text(ScalarType::f64, bits_of(inputs.dt)) + " s";
  return text;
}

void add_inputs(const DesyncFinding& finding, std::string& text) {
  std::vector<std::optional<TickInputs>> inputs;
  const TickInputs* first = nullptr;
  bool differ = false, dt_differs = false;
  for (const DesyncPlayer& player : finding.players) {
    inputs.push_back(player.inputs);
    if (!player.inputs) continue;
    if (first == nullptr) first = &*player.inputs;
    differ = differ || !(*first == *player.inputs);
    dt_differs = dt_differs || bits_of(first->dt) != bits_of(player.inputs->dt);
  }
  if (first == nullptr) return;
  if (!differ) {
    add_line(text, "input", "the same for all: " + inputs_text(*first, false));
    return;
  }
  add_line(text, "input", "not the same for all: the tick ran with other inputs");
  add_line(text, "", grouped(finding, inputs, [&](const TickInputs& one) { return inputs_text(one, dt_differs); }));
}

void add_facts(const DesyncFinding& finding, std::string& text) {
  const DesyncPlayer* first = nullptr;
  std::string label = "differs";
  for (const DesyncPlayer& player : finding.players) {
    if (player.facts.empty()) continue;
    if (first == nullptr) {
      first = &player;
      continue;
    }
    for (const FactDifference& difference : fact_differences(first->facts, player.facts)) {
      add_line(text, label,
               difference_line(difference, "player " + std::to_string(first->player),
                               "player " + std::to_string(player.player)));
      label = "";
    }
  }
}

/// The players outside the largest group with one root; empty: two groups are equally large.
Names odd_ones(const DesyncFinding& finding) {
  const std::vector<Names> groups = root_groups(finding);
  Names others;
  if (groups.size() < 2 || groups[0].size() == groups[1].size()) return others;
  for (std::size_t g = 1; g < groups.size(); ++g) others.insert(others.end(), groups[g].begin(), groups[g].end());
  std::sort(others.begin(), others.end());
  return others;
}

std::string who_text(const DesyncFinding& finding) {
  const std::vector<Names> groups = root_groups(finding);
  const Names others = odd_ones(finding);
  if (!others.empty())
    return players_text(finding, groups[0]) + " agree; " + players_text(finding, others) +
           (others.size() == 1 ? " is the odd one out" : " are the odd ones out");
  std::string text;
  for (const Names& group : groups) text += (text.empty() ? "" : ", ") + players_text(finding, group);
  return text + " differ, and no majority says which is right";
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void add_missing(const DesyncFinding& finding, std::string& text) {
  for (const DesyncPlayer& player : finding.players) {
    const std::string name = "player " + std::to_string(player.player);
    if (!player.root)
      add_line(text, "missing", name + ": its root of this tick is not known");
    else if (player.lost_state)
      add_line(text, "missing", name + ": keeps the state of this tick no more (peer_bytes of the options)");
    else if (!player.tables)
      add_line(text, "missing",
               name + ": its state is not known" +
                   (player.hashed.empty() ? " yet" : "; by their hashes differ " + joined(player.hashed)));
  }
}

nlohmann::ordered_json lane_object(const StateSchema& schema, const DesyncFinding& finding, const DesyncLane& lane) {
  const TableSchema& table = schema.tables[lane.place.table];
  const Column& column = table.columns[lane.place.column];
  nlohmann::ordered_json object{{"table", plain_line(table.name)},
                                {"column", plain_line(column.name)},
                                {"row", lane.place.row},
                                {"lane", lane.place.lane}};
  if (lane.id) object["id"] = *lane.id;
  if (!lane.name.empty()) object["name"] = plain_line(lane.name);
  if (!lane.where.empty()) object["place"] = plain_line(lane.where);
  object["values"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < finding.players.size(); ++i) {
    if (!finding.players[i].tables) continue;
    nlohmann::ordered_json value{{"player", finding.players[i].player}, {"bits", nullptr}};
    if (lane.values[i]) {
      value["bits"] = lane_hex(column.type, *lane.values[i]);
      value["value"] = value_json(column.type, *lane.values[i]);
    }
    object["values"].push_back(std::move(value));
  }
  return object;
}

nlohmann::ordered_json content_object(const DesyncFinding& finding, const DesyncContent& content) {
  const ContentDifference& what = content.what;
  nlohmann::ordered_json object{{"place", plain_line(what.place)},
                                {"table", plain_line(what.table)},
                                {"kind", what.is_text ? "text" : "bytes"},
                                {"row", what.top.row}};
  if (what.id) object["id"] = *what.id;
  if (!content.name.empty()) object["name"] = plain_line(content.name);
  object["first"] = what.first;
  object["byte"] = what.offset;
  object["character"] = nullptr;
  if (what.character) object["character"] = *what.character;
  object["values"] = nlohmann::ordered_json::array();
  const std::vector<std::optional<ShownSide>> sides = known_sides(finding, content);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (!sides[i]) continue;
    nlohmann::ordered_json value{{"player", finding.players[i].player}, {"value", nullptr}};
    if (const ShownSide& side = *sides[i]) {
      value["value"] = what.is_text ? side->bytes : hex_text(side->bytes);
      value["size"] = side->size;
    }
    object["values"].push_back(std::move(value));
  }
  return object;
}

/// `compared`: the players whose states may differ, the first one in front.
void compare_contents(const StateSchema& schema, const Names& compared, const RowNamer& row_name,
                      DesyncFinding& finding) {
  std::vector<std::span<const ImageTable>> states;
  for (const std::size_t i : compared) states.push_back(*finding.players[i].tables);
  ContentDifferences found = find_content_differences(schema, states, content_shown_max);
  finding.content_count = found.count;
  for (ContentDifference& what : found.list) {
    DesyncContent& content = finding.contents.emplace_back();
    // Who is not compared has the root of the first player.
    content.sides.assign(finding.players.size(), what.sides[0]);
    for (std::size_t i = 1; i < compared.size(); ++i) content.sides[compared[i]] = std::move(what.sides[i]);
    what.sides.clear();
    if (row_name) content.name = row_name(what.top.table, what.top.row);
    content.what = std::move(what);
  }
}

/// Who has the root of another player has its values.
template <typename Value>
void share_by_root(const DesyncFinding& finding, std::vector<Value>& values) {
  for (std::size_t i = 0; i < finding.players.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (finding.players[j].tables && finding.players[i].root && finding.players[i].root == finding.players[j].root)
        values[i] = values[j];
}

}  // namespace

void compare_players(const StateSchema& schema, const RowNamer& row_name, DesyncFinding& finding) {
  const auto has_state = [](const DesyncPlayer& player) { return player.tables.has_value(); };
  const auto first = std::find_if(finding.players.begin(), finding.players.end(), has_state);
  finding.lanes.clear();
  finding.contents.clear();
  finding.lane_count = finding.content_count = 0;
  if (first == finding.players.end()) return;
  const auto first_index = static_cast<std::size_t>(first - finding.players.begin());
  Names compared{first_index};
  std::map<LaneKey, DesyncLane> lanes;
  for (std::size_t i = first_index + 1; i < finding.players.size(); ++i) {
    const DesyncPlayer& player = finding.players[i];
    if (!player.tables || player.root == first->root) continue;
    compared.push_back(i);
    for (const LaneDifference& difference :
         diff_images(schema, *first->tables, *player.tables, compared_lane_count_max)) {
      if (has_pieces(schema.tables[difference.place.table])) continue;
      DesyncLane& lane = lanes[lane_key(difference)];
      if (lane.values.empty()) {
        lane.place = difference.place;
        lane.id = difference.id;
        lane.where = child_place(schema, difference.expected ? *first->tables : *player.tables, difference.place.table,
                                 difference.place.row);
        lane.values.assign(finding.players.size(), difference.expected);
      }
      lane.values[i] = difference.got;
    }
  }
  finding.lane_count = lanes.size();
  for (auto& [key, lane] : lanes) {
    if (finding.lanes.size() == lane_shown_max) break;
    share_by_root(finding, lane.values);
    if (row_name) lane.name = row_name(lane.place.table, lane.place.row);
    finding.lanes.push_back(std::move(lane));
  }
  compare_contents(schema, compared, row_name, finding);
  for (DesyncContent& content : finding.contents) share_by_root(finding, content.sides);
}

std::vector<Names> root_groups(const DesyncFinding& finding) {
  std::vector<Names> groups;
  for (std::size_t i = 0; i < finding.players.size(); ++i) {
    if (!finding.players[i].root) continue;
    const auto same = [&](const Names& group) { return finding.players[group[0]].root == finding.players[i].root; };
    const auto found = std::find_if(groups.begin(), groups.end(), same);
    if (found == groups.end())
      groups.push_back({i});
    else
      found->push_back(i);
  }
  std::stable_sort(groups.begin(), groups.end(), [](const Names& a, const Names& b) { return a.size() > b.size(); });
  return groups;
}

std::string desync_text(const StateSchema& schema, const DesyncFinding& finding) {
  std::string text = "desync  " + plain_line(finding.simulation) + "  tick " + std::to_string(finding.tick) + "\n";
  add_line(text, "who", who_text(finding));
  add_line(
      text, "agreed",
      finding.agreed ? "up to tick " + std::to_string(*finding.agreed) : std::string("no tick before it is known"));
  for (const DesyncLane& lane : finding.lanes) {
    const TableSchema& table = schema.tables[lane.place.table];
    const Column& column = table.columns[lane.place.column];
    std::string name = table.name + "." + column.name;
    if (name.size() < 17) name.resize(17, ' ');
    add_line(text, "column", name + " " + row_text(column, lane));
    add_line(text, "value", values_text(finding, column, lane));
  }
  for (const DesyncContent& content : finding.contents) {
    add_line(text, content.what.is_text ? "text" : "bytes",
             content_place(content.what.place, content.what.id, content.name));
    add_line(text, "value", contents_text(finding, content));
  }
  if (finding.lane_count > finding.lanes.size() || finding.content_count > finding.contents.size() || finding.is_cut)
    add_line(text, "more", (finding.is_cut ? "at least " : "") + difference_count_text(finding) + " differ");
  std::vector<std::optional<std::uint64_t>> roots;
  for (const DesyncPlayer& player : finding.players) roots.push_back(player.root);
  add_line(text, "hash", grouped(finding, roots, hex64));
  add_inputs(finding, text);
  add_facts(finding, text);
  add_missing(finding, text);
  return text;
}

std::string desync_json(const StateSchema& schema, const DesyncFinding& finding) {
  using Json = nlohmann::ordered_json;
  Json object{{"schema", "ticktrue.desync/2"}, {"simulation", plain_line(finding.simulation)}, {"tick", finding.tick}};
  object["agreed"] = finding.agreed ? Json(*finding.agreed) : Json(nullptr);
  object["complete"] = finding.is_whole;
  object["players"] = Json::array();
  for (const DesyncPlayer& player : finding.players) {
    Json one{{"player", player.player}, {"root", nullptr}};
    if (player.root) one["root"] = hex64(*player.root);
    object["players"].push_back(std::move(one));
  }
  object["odd"] = Json::array();
  for (const std::size_t i : odd_ones(finding)) object["odd"].push_back(finding.players[i].player);
  object["differing"] = finding.lane_count;
  object["values"] = Json::array();
  for (const DesyncLane& lane : finding.lanes) object["values"].push_back(lane_object(schema, finding, lane));
  if (finding.content_count > 0) {
    object["contents"] = Json::array();
    for (const DesyncContent& content : finding.contents)
      object["contents"].push_back(content_object(finding, content));
    object["content_count"] = finding.content_count;
  }
  // A text may hold bytes that are no UTF-8.
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace ticktrue::verifier
