// Build ids of programs, from ELF files of every kind and from what is none; the build that recorded a trace.
// SPDX-License-Identifier: MIT
#include "verifier/programs/program_builds.h"

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "capi/program_facts.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/programs/elf_file.h"
#include "verifier/report/build_id_note.h"

namespace ticktrue::test {
namespace {

namespace fs = std::filesystem;
using verifier::ProgramBuilds;

/// What stands in an ELF file with one segment of notes: a foreign note, then a build id.
struct ElfPlan {
  bool is_64 = true;
  verifier::ByteOrder order = verifier::ByteOrder::little;
  std::uint64_t alignment = 4;
  std::string id = "\x01\xab\xff";  // bytes
};

class ElfWriter {
 public:
  explicit ElfWriter(const ElfPlan& plan) : plan_(plan) {}

  std::string file() {
    const std::size_t word = plan_.is_64 ? 8 : 4;
    const std::size_t header_size = plan_.is_64 ? 64 : 52;
    const std::size_t segment_size = plan_.is_64 ? 56 : 32;
    const std::size_t notes_at = 256;
    const std::string notes = note("Linux", 1, "abcdefg") + note(std::string("GNU"), 3, plan_.id);
    text_ =
        "\x7f"
        "ELF";
    add(plan_.is_64 ? 2 : 1, 1), add(plan_.order == verifier::ByteOrder::little ? 1 : 2, 1), add(1, 1);
    text_.resize(16);
    add(3, 2), add(62, 2), add(1, 4);                    // type, machine, version
    add(0, word), add(header_size, word), add(0, word);  // entry, program headers, sections
    add(0, 4), add(header_size, 2), add(segment_size, 2), add(1, 2);
    text_.resize(header_size);
    add(4, 4);
    if (plan_.is_64) add(4, 4);
    add(notes_at, word), add(0, word), add(0, word), add(notes.size(), word), add(notes.size(), word);
    if (!plan_.is_64) add(4, 4);
    add(plan_.alignment, word);
    text_.resize(notes_at);
    return text_ + notes;
  }

 private:
  void add(std::uint64_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      text_ += static_cast<char>(value >> 8 * (plan_.order == verifier::ByteOrder::little ? i : size - 1 - i));
  }

  std::string note(const std::string& owner, std::uint32_t type, const std::string& content) {
    const auto pad = [&](std::string& text) {
      while (text.size() % plan_.alignment != 0) text += '\0';
    };
    std::string whole;
    std::swap(text_, whole);
    add(owner.size() + 1, 4), add(content.size(), 4), add(type, 4);
    std::string name = owner + '\0', body = content;
    pad(name);
    pad(body);
    std::string made = text_ + name + body;
    std::swap(text_, whole);
    return made;
  }

  ElfPlan plan_;
  std::string text_;
};

std::string id_of(const std::string& bytes) {
  std::istringstream in(bytes);
  return verifier::elf_build_id(in);
}

TEST_CASE("the build id of a file is that of the process that runs it", "[verifier][builds][equivalence]") {
  std::ifstream in("/proc/self/exe", std::ios::binary);
  SKIP_UNLESS(in.good(), "a system without /proc");
  CHECK(verifier::elf_build_id(in) == capi::program_build_id());
}

TEST_CASE("the build id of 32 and 64 bits, of both byte orders and alignments, is read",
          "[verifier][builds][analytic]") {
  for (const bool is_64 : {false, true})
    for (const verifier::ByteOrder order : {verifier::ByteOrder::little, verifier::ByteOrder::big})
      for (const std::uint64_t alignment : {4u, 8u}) {
        CAPTURE(is_64, order == verifier::ByteOrder::big, alignment);
        CHECK(id_of(ElfWriter({is_64, order, alignment}).file()) == "01abff");
      }
}

TEST_CASE("a file that is cut or changed has its build id, another one, or none", "[verifier][builds][corruption]") {
  for (const bool is_64 : {false, true}) {
    const std::string whole = ElfWriter({is_64}).file();
    for (std::size_t size = 0; size < whole.size() - 1; ++size) {  // the last byte is padding
      CAPTURE(is_64, size);
      CHECK(id_of(whole.substr(0, size)).empty());
    }
    std::mt19937 random(3);
    for (int i = 0; i < 20'000; ++i) {
      std::string changed = whole;
      for (std::size_t n = 1 + random() % 3; n > 0; --n)
        changed[random() % 3 == 0 ? random() % changed.size() : random() % 120] =
            random() % 3 == 0 ? '\xff' : static_cast<char>(random());
      const std::string id = id_of(changed);
      CHECK(id.size() <= 128);
      CHECK(id.find_first_not_of("0123456789abcdef") == std::string::npos);
    }
  }
  CHECK(id_of("").empty());
  CHECK(id_of("#!/bin/sh\necho\n").empty());
  CHECK(id_of(std::string(300, '\xff')).empty());
  CHECK(id_of(ElfWriter({true, verifier::ByteOrder::little, 4, std::string(65, 'x')}).file()).empty());
}

void write_program(const std::string& path, const std::string& id, bool is_executable = true) {
  ElfPlan plan;
  plan.id = id;
  std::ofstream(path, std::ios::binary) << ElfWriter(plan).file();
  if (is_executable) fs::permissions(path, fs::perms::owner_all);
}

/// A trace whose facts name this build.
std::string trace_of(const TemporaryFolder& folder, const std::string& name, const replay::BuildFacts& facts) {
  const std::string path = folder.file(name);
  auto writer = replay::TraceWriter::create(path, toy_setup(2), facts, plain_writer());
  REQUIRE(writer);
  ToySimulation toy(2);
  REQUIRE(writer->checkpoint(toy.state(), root_hash(toy.state())));
  REQUIRE(writer->finish(replay::EndReason::complete, ""));
  return path;
}

TEST_CASE("a trace is matched with the build that recorded it", "[verifier][builds][analytic]") {
  const TemporaryFolder folder;
  const std::string builds = folder.file("builds");
  fs::create_directories(builds + "/deep/er");
  write_program(builds + "/b", "\x02");
  write_program(builds + "/a", "\x02");  // a copy: the first by name counts
  write_program(builds + "/deep/er/c", "\x03");
  write_program(builds + "/b.debug", "\x04", false);
  std::ofstream(builds + "/notes.txt") << "text";
  const auto found = ProgramBuilds::find(builds);
  REQUIRE(found);
  const auto recorder = [&](const std::string& name, const replay::BuildFacts& facts) {
    return found->recorder_of(trace_of(folder, name, facts));
  };
  CHECK(*recorder("2.ttr", {{"version", "1"}, {"program.build_id", "02"}}) == builds + "/a");
  CHECK(*recorder("3.ttr", {{"program.build_id", "03"}}) == builds + "/deep/er/c");
  const auto debug = recorder("4.ttr", {{"program.build_id", "04"}});  // it cannot be run
  REQUIRE(!debug);
  CHECK(debug.error().code == ErrorCode::incompatible);
  CHECK(contains(debug.error().message, "recorded by build id 04: found none such in " + builds + " (2 builds)"));
  const auto unnamed = recorder("5.ttr", {{"version", "1"}});
  REQUIRE(!unnamed);
  CHECK(unnamed.error().code == ErrorCode::incompatible);
  CHECK(contains(unnamed.error().message, "names no build id"));
  CHECK(!found->recorder_of(folder.file("none.ttr")));
}

TEST_CASE("a folder without builds is refused", "[verifier][builds][corruption]") {
  const TemporaryFolder folder;
  fs::create_directory(folder.file("empty"));
  std::ofstream(folder.file("file")) << "x";
  for (const char* name : {"empty", "none", "file"}) {
    CAPTURE(name);
    const auto found = ProgramBuilds::find(folder.file(name));
    REQUIRE(!found);
    CHECK(found.error().code == ErrorCode::usage);
  }
}

}  // namespace
}  // namespace ticktrue::test
