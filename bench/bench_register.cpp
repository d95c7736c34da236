// The cost of registering a program's tables: at the first tick, and again if the tables move in every tick.
// SPDX-License-Identifier: MIT
//
//   bench_register [TABLES COLUMNS]     300 tables of 20 columns unless told; best of 50, in microseconds
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "include/ticktrue.h"

namespace {

constexpr int round_count = 50;

double microseconds_of(void (*work)(ticktrue_session*), ticktrue_session* session) {
  const auto begin = std::chrono::steady_clock::now();
  work(session);
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<std::string> tables;
std::vector<std::string> columns;
std::vector<float> row;
std::vector<std::uint32_t> numbers;
std::vector<ticktrue_member> members;

void register_columns(ticktrue_session* session) {
  for (const std::string& table : tables)
    for (std::size_t c = 0; c < columns.size(); ++c)
      ticktrue_column(session, table.c_str(), columns[c].c_str(), &row[c], TICKTRUE_F32, 1, 1, 0);
}

void register_tables(ticktrue_session* session) {
  numbers.clear();
  for (const std::string& table : tables)
    numbers.push_back(ticktrue_table(session, table.c_str(), sizeof(float) * row.size(), members.data(),
                                     static_cast<std::uint32_t>(members.size())));
}

void move_rows(ticktrue_session* session) {
  for (const std::uint32_t number : numbers) ticktrue_rows(session, number, row.data(), 1);
}

/// Registers for the first time, and again. Both times are the best of all rounds.
int measure(const char* what, void (*first)(ticktrue_session*), void (*again)(ticktrue_session*)) {
  double first_us = 1e18, again_us = 1e18;
  for (int round = 0; round < round_count; ++round) {
    ticktrue_options options = {};
    options.struct_size = sizeof options;
    options.mode = TICKTRUE_RECORD;
    options.path = "bench_register.ttr";  // never written, since no tick begins
    options.name = "bench-register";
    options.flags = TICKTRUE_QUIET;
    ticktrue_session* session = ticktrue_open(&options);
    first_us = std::min(first_us, microseconds_of(first, session));
    again_us = std::min(again_us, microseconds_of(again, session));
    const bool failed = ticktrue_status(session) != TICKTRUE_OK;
    if (failed) std::fprintf(stderr, "bench_register: error: %s\n", ticktrue_message(session));
    ticktrue_close(session);
    if (failed) return 2;
  }
  std::printf("%-16s %10.1f us first %10.1f us again\n", what, first_us, again_us);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const int table_count = argc > 1 ? std::atoi(argv[1]) : 300;
  const int column_count = argc > 2 ? std::atoi(argv[2]) : 20;
  if (table_count < 1 || column_count < 1) {
    std::fprintf(stderr, "usage: bench_register [TABLES COLUMNS]\n");
    return 2;
  }
  for (int t = 0; t < table_count; ++t) tables.push_back("units_of_player_" + std::to_string(t));
  for (int c = 0; c < column_count; ++c) columns.push_back("column_" + std::to_string(c));
  row.resize(columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c)
    members.push_back({columns[c].c_str(), TICKTRUE_F32, 1, c * sizeof(float), sizeof(float)});
  std::printf("%d tables of %d columns\n", table_count, column_count);
  if (measure("ticktrue_column", register_columns, register_columns) != 0) return 2;
  return measure("ticktrue_table", register_tables, move_rows);
}
