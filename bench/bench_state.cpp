// The cost of a tick of a session by the shape of its state: child tables beside flat columns, 300 tables beside one.
// SPDX-License-Identifier: MIT
//
//   bench_state [OWNERS [TICKS]]     1,000 owners and 400 ticks unless told
//
// Shapes that are compared run their ticks in turns, in blocks of ten. A line has the median time of begin_tick and
// end_tick in microseconds of processor time, the median ratio to the shape named last, and the hash of the last state.
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <ticktrue.hpp>
#include <vector>

namespace bench_state {

constexpr std::size_t item_count = 8;

struct Item {
  std::uint16_t kind;
  std::uint32_t count;
  std::string label;
};
TICKTRUE_COLUMNS(Item, kind, count, label)
struct Owner {
  std::uint32_t id;
  float health;
  std::string name;
  std::vector<Item> items;
};
TICKTRUE_COLUMNS(Owner, key(id), health, name, items)

/// The same values in one row.
struct FlatItem {
  std::uint16_t kind;
  std::uint32_t count;
  char label[12];
};
TICKTRUE_COLUMNS(FlatItem, kind, count, label)
struct FlatOwner {
  std::uint32_t id;
  float health;
  char name[24];
  FlatItem items[item_count];
};
TICKTRUE_COLUMNS(FlatOwner, key(id), health, name, items)

/// The rows that child tables have, as plain tables of the program.
struct PlainOwner {
  std::uint32_t id;
  float health;
};
TICKTRUE_COLUMNS(PlainOwner, key(id), health)
struct Piece {
  std::uint32_t owner, index, size, bytes[5];
};
TICKTRUE_COLUMNS(Piece, key(owner), key(index), size, bytes)
struct PlainItem {
  std::uint32_t owner, index;
  std::uint16_t kind;
  std::uint32_t count;
};
TICKTRUE_COLUMNS(PlainItem, key(owner), key(index), kind, count)

struct Row {
  float values[4];
};
TICKTRUE_COLUMNS(Row, values)

std::string name_of(std::size_t owner) {
  char name[32];
  std::snprintf(name, sizeof name, "owner %018zu", owner);
  return name;
}
std::string label_of(std::size_t owner, std::size_t item) {
  char label[32];
  std::snprintf(label, sizeof label, "label %06zu", (owner * item_count + item) % 1'000'000);
  return label;
}

/// A program with a state of one shape.
class Shape {
 public:
  virtual ~Shape() = default;
  virtual const char* name() const = 0;
  virtual void show(ticktrue::Session& session) = 0;
  virtual void step(std::uint32_t tick) = 0;
};

class ChildShape : public Shape {
 public:
  explicit ChildShape(std::size_t count) : owners_(count) {
    for (std::size_t o = 0; o < count; ++o) {
      owners_[o] = {static_cast<std::uint32_t>(o), 1, name_of(o), {}};
      for (std::size_t i = 0; i < item_count; ++i) owners_[o].items.push_back({7, 1, label_of(o, i)});
    }
  }
  const char* name() const override { return "child tables"; }
  void show(ticktrue::Session& session) override { session.table("owners", owners_); }
  void step(std::uint32_t tick) override {
    for (Owner& owner : owners_) {
      owner.health += 0.5f;
      ++owner.items[tick % item_count].count;
    }
  }

 private:
  std::vector<Owner> owners_;
};

class FlatShape : public Shape {
 public:
  explicit FlatShape(std::size_t count) : owners_(count) {
    for (std::size_t o = 0; o < count; ++o) {
      owners_[o].id = static_cast<std::uint32_t>(o);
      owners_[o].health = 1;
      std::memcpy(owners_[o].name, name_of(o).data(), sizeof owners_[o].name);
      for (std::size_t i = 0; i < item_count; ++i) {
        owners_[o].items[i].kind = 7;
        owners_[o].items[i].count = 1;
        std::memcpy(owners_[o].items[i].label, label_of(o, i).data(), sizeof owners_[o].items[i].label);
      }
    }
  }
  const char* name() const override { return "flat columns"; }
  void show(ticktrue::Session& session) override { session.table("owners", owners_); }
  void step(std::uint32_t tick) override {
    for (FlatOwner& owner : owners_) {
      owner.health += 0.5f;
      ++owner.items[tick % item_count].count;
    }
  }

 private:
  std::vector<FlatOwner> owners_;
};

class PlainShape : public Shape {
 public:
  explicit PlainShape(std::size_t count) {
    for (std::size_t o = 0; o < count; ++o) {
      owners_.push_back({static_cast<std::uint32_t>(o), 1});
      add_text(names_, static_cast<std::uint32_t>(o), name_of(o));
      for (std::size_t i = 0; i < item_count; ++i) {
        items_.push_back({static_cast<std::uint32_t>(o), static_cast<std::uint32_t>(i), 7, 1});
        add_text(labels_, static_cast<std::uint32_t>(o * item_count + i), label_of(o, i));
      }
    }
  }
  const char* name() const override { return "plain tables"; }
  void show(ticktrue::Session& session) override {
    session.table("owners", owners_);
    session.table("names", names_);
    session.table("items", items_);
    session.table("labels", labels_);
  }
  void step(std::uint32_t tick) override {
    for (PlainOwner& owner : owners_) owner.health += 0.5f;
    for (std::size_t i = tick % item_count; i < items_.size(); i += item_count) ++items_[i].count;
  }

 private:
  static void add_text(std::vector<Piece>& pieces, std::uint32_t owner, const std::string& text) {
    for (std::size_t at = 0, index = 0; at < text.size(); at += sizeof(Piece::bytes), ++index) {
      Piece piece{owner, static_cast<std::uint32_t>(index), 0, {}};
      piece.size = static_cast<std::uint32_t>(std::min(text.size() - at, sizeof piece.bytes));
      std::memcpy(piece.bytes, text.data() + at, piece.size);
      pieces.push_back(piece);
    }
  }

  std::vector<PlainOwner> owners_;
  std::vector<Piece> names_, labels_;
  std::vector<PlainItem> items_;
};

/// Rows of four floats in so many tables; of the first `changed` tables, or that many parts, all rows change.
class TableShape : public Shape {
 public:
  TableShape(const char* name, std::size_t table_count, std::size_t row_count, std::size_t changed_rows)
      : name_(name), tables_(table_count, std::vector<Row>(row_count)), changed_(changed_rows) {}
  const char* name() const override { return name_; }
  void show(ticktrue::Session& session) override {
    for (std::size_t t = 0; t < tables_.size(); ++t) session.table(("units_" + std::to_string(t)).c_str(), tables_[t]);
  }
  void step(std::uint32_t) override {
    std::size_t left = changed_;
    for (std::vector<Row>& rows : tables_)
      for (Row& row : rows) {
        if (left-- == 0) return;
        row.values[1] += 0.5f;
      }
  }

 private:
  const char* name_;
  std::vector<std::vector<Row>> tables_;
  std::size_t changed_;
};

double processor_us() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e6 + static_cast<double>(time.tv_nsec) / 1e3;
}

double median(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  return samples.empty() ? 0 : samples[samples.size() / 2];
}

struct Way {
  const char* name;
  int mode;
  int detail;
};

/// A session of a shape, and what its ticks took.
class Run {
 public:
  Run(Shape& shape, const Way& way, int number) : shape_(shape) {
    path_ = (std::filesystem::temp_directory_path() /
             ("ticktrue_bench_state_" + std::to_string(::getpid()) + "_" + std::to_string(number) + ".ttr"))
                .string();
    ticktrue::Options options("bench-state");
    options.mode = way.mode;
    options.detail = way.detail;
    options.path = way.mode == TICKTRUE_RECORD ? path_.c_str() : nullptr;
    options.checkpoint_interval = 1'000'000;
    options.flags = TICKTRUE_OVERWRITE | TICKTRUE_NO_SYNC | TICKTRUE_QUIET;
    if (way.mode == TICKTRUE_RECORD) options.flags |= TICKTRUE_MARKS;  // format version 3 for every shape
    session_ = std::make_unique<ticktrue::Session>(options);
    const double begin = processor_us();
    shape_.show(*session_);
    first_us = processor_us() - begin + tick();
  }
  Run(const Run&) = delete;
  ~Run() {
    session_.reset();
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

  /// The time of a tick without that of the program.
  double tick() {
    const double begin = processor_us();
    if (!session_->begin_tick()) fail();
    const double inside = processor_us();
    shape_.step(tick_++);
    const double behind = processor_us();
    if (!session_->end_tick()) fail();
    return processor_us() - behind + inside - begin;
  }
  std::uint64_t root() {
    std::uint64_t root = 0;
    if (ticktrue_root(session_->handle(), tick_ - 1, &root) != TICKTRUE_OK) fail();
    return root;
  }

  double first_us = 0;  // registering, and the first tick
  std::vector<double> block_us;

 private:
  [[noreturn]] void fail() {
    std::fprintf(stderr, "bench_state: error: %s\n", session_->error());
    std::exit(2);
  }

  Shape& shape_;
  std::string path_;
  std::unique_ptr<ticktrue::Session> session_;
  std::uint32_t tick_ = 0;
};

constexpr std::size_t block_size = 10;

void compare(const std::vector<std::function<std::unique_ptr<Shape>()>>& makers, const std::vector<Way>& ways,
             std::size_t tick_count) {
  for (const Way& way : ways) {
    std::vector<std::unique_ptr<Shape>> shapes;
    std::vector<std::unique_ptr<Run>> runs;
    for (const auto& make : makers) {
      shapes.push_back(make());
      runs.push_back(std::make_unique<Run>(*shapes.back(), way, static_cast<int>(runs.size())));
    }
    for (std::size_t done = 0; done < tick_count; done += block_size)
      for (const std::unique_ptr<Run>& run : runs) {
        double block = 0;
        for (std::size_t i = 0; i < block_size; ++i) block += run->tick();
        run->block_us.push_back(block);
      }
    for (std::size_t r = 0; r < runs.size(); ++r) {
      std::vector<double> ratios;
      for (std::size_t b = 0; b < runs[r]->block_us.size(); ++b)
        ratios.push_back(runs[r]->block_us[b] / runs.back()->block_us[b]);
      std::printf("  %-8s %-36s %9.1f us a tick %7.2f times  first %9.1f us  hash %016llx\n", way.name,
                  shapes[r]->name(), median(runs[r]->block_us) / block_size, median(std::move(ratios)),
                  runs[r]->first_us, static_cast<unsigned long long>(runs[r]->root()));
    }
  }
}

}  // namespace bench_state

int main(int argc, char** argv) {
  using namespace bench_state;
  const std::size_t owners = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1'000;
  const std::size_t ticks = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 400;
  if (owners == 0 || ticks == 0) {
    std::fprintf(stderr, "usage: bench_state [OWNERS [TICKS]]\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 12);
  const std::vector<Way> ways{{"live", TICKTRUE_LIVE, TICKTRUE_DETAIL_ROOT},
                              {"root", TICKTRUE_RECORD, TICKTRUE_DETAIL_ROOT},
                              {"cells", TICKTRUE_RECORD, TICKTRUE_DETAIL_CELLS},
                              {"full", TICKTRUE_RECORD, TICKTRUE_DETAIL_FULL}};
  std::printf("%zu owners, each with a name of 24 bytes and %zu items with a label of 12: as child tables, as plain\n",
              owners, item_count);
  std::printf("tables of the same rows, and as columns of one row\n");
  compare({[&] { return std::make_unique<ChildShape>(owners); }, [&] { return std::make_unique<PlainShape>(owners); },
           [&] { return std::make_unique<FlatShape>(owners); }},
          ways, ticks);
  constexpr std::size_t tables = 300, rows = 1'000;
  std::printf("%zu tables of %zu rows of 16 bytes beside one table of as many rows\n", tables, rows);
  const auto of_tables = [](const char* name, std::size_t count, std::size_t changed) {
    return [=]() -> std::unique_ptr<Shape> {
      return std::make_unique<TableShape>(name, count, tables * rows / count, changed);
    };
  };
  compare({of_tables("300 tables, all rows change", tables, tables * rows),
           of_tables("300 tables, one table changes", tables, rows), of_tables("one table, 1,000 rows change", 1, rows),
           of_tables("one table, all rows change", 1, tables * rows)},
          {ways[0], ways[1], ways[2]}, std::min<std::size_t>(ticks, 50));
  return 0;
}
