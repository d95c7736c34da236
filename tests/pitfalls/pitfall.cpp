// Saves, loads and shows the whole state of the tiny game, so that only its rules can be wrong.
// SPDX-License-Identifier: MIT
#include "tests/pitfalls/pitfall.h"

namespace ticktrue::pitfalls {
namespace {

StateSchema make_schema() {
  StateSchema schema;
  schema.tables.resize(2);
  schema.tables[0].name = "world";
  schema.tables[0].row_size = 8;
  schema.tables[0].columns.resize(1);
  schema.tables[0].columns[0].name = "tick";
  schema.tables[0].columns[0].type = ScalarType::u64;
  TableSchema& units = schema.tables[1];
  units.name = "units";
  units.key_column_count = 1;
  for (const auto& [name, type] : {std::pair("id", ScalarType::u32), std::pair("position", ScalarType::f32),
                                   std::pair("velocity", ScalarType::f32), std::pair("score", ScalarType::i32)}) {
    Column column;
    column.name = name;
    column.type = type;
    column.offset = static_cast<std::uint16_t>(units.row_size);
    units.row_size += 4;
    units.columns.push_back(column);
  }
  return schema;
}
const StateSchema schema = make_schema();

}  // namespace

Machine machine = Machine::recorder;

Game::Game(std::uint32_t unit_count) : units(unit_count) {
  for (std::uint32_t i = 0; i < unit_count; ++i) {
    units[i].id = i;
    units[i].position = 1.5F + 0.7F * static_cast<float>(i);
    units[i].velocity = -1.0F - 0.1F * static_cast<float>(i);
  }
  view_.schema = &schema;
  view_.tables = {{reinterpret_cast<const std::uint8_t*>(&tick_), 1},
                  {reinterpret_cast<const std::uint8_t*>(units.data()), unit_count}};
}

Status Game::step(const TickInput& input, StageObserver*) {
  const auto dt = static_cast<float>(input.dt);
  for (Unit& unit : units) unit.position += unit.velocity * dt;
  rules(dt);
  ++tick_;
  return {};
}

Status Game::load(ByteView image) {
  const auto tables = check_image(schema, image);
  if (!tables) return tables.error();
  if ((*tables)[0].row_count != 1 || (*tables)[1].row_count != units.size())
    return Error{ErrorCode::corrupt, "game image: rows: found another number", ""};
  decode_rows(schema.tables[0], (*tables)[0], reinterpret_cast<std::uint8_t*>(&tick_));
  decode_rows(schema.tables[1], (*tables)[1], reinterpret_cast<std::uint8_t*>(units.data()));
  return {};
}

std::string Game::row_name(std::size_t table, std::size_t row) const {
  return table == 1 ? "unit_" + std::to_string(units[row].id) : "";
}

}  // namespace ticktrue::pitfalls
