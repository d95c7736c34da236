// Each row: the change, the conditions for it, and how to fix its source.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/perturbations.h"

#include <algorithm>
#include <iterator>

#include "tool/experiment/shake/dispatch.h"

#ifdef __linux__
#include <sys/personality.h>
#endif

namespace ticktrue::shake {
namespace {

using shim::Group;

constexpr std::int64_t day_s = 86400;
constexpr std::int64_t year_s = 365 * day_s;

// --- conditions -----------------------------------------------------------------------------------------------------

std::string always(const Facts&) {
  return "";
}

std::string shim_loaded(const Facts& facts) {
  return facts.no_shim;
}

/// ticktrue checks its float settings and refuses others.
std::string needs_other_program(const Facts& facts) {
  return facts.is_this_tool ? "ticktrue does not verify under other float settings" : facts.no_shim;
}

std::string calls_made(const Facts& facts, Group group, const char* what) {
  if (!facts.no_shim.empty()) return facts.no_shim;
  return facts.control.calls_of(group) == 0 ? std::string("the program ") + what : "";
}

template <Group group>
std::string needs_calls(const Facts& facts) {
  switch (group) {
    case Group::heap:
      return calls_made(facts, group, "does not use malloc");
    case Group::clock:
      return calls_made(facts, group, "reads no clock through the C library");
    case Group::random:
      return calls_made(facts, group, "asks for no random bytes through the C library");
    case Group::rand:
      return calls_made(facts, group, "does not call rand, random or drand48");
    case Group::directory:
      return calls_made(facts, group, "reads no directory");
    case Group::thread:
      return calls_made(facts, group, "starts no thread");
    case Group::lock:
      return calls_made(facts, Group::thread, "starts no thread");
    case Group::processors:
      return calls_made(facts, group, "does not ask how many processors there are");
    case Group::sort:
      return calls_made(facts, group, "does not call qsort");
    case Group::libm:
      return calls_made(facts, group, "does not call libm");
    case Group::identity:
      return calls_made(facts, group, "does not ask for the name of the machine");
    case Group::cycle_counter:
      break;
  }
  return "";
}

std::string linux_only(const Facts&) {
#ifdef __linux__
  return "";
#else
  return "Linux only";
#endif
}

std::string needs_unread_output(const Facts& facts) {
  return facts.control.has_session ? "" : "the program prints its report";
}

std::string needs_allocator(const Facts& facts) {
  return facts.allocators.empty()
             ? "no other allocator is installed: apt-get install libjemalloc2 libtcmalloc-minimal4 libmimalloc2.0"
             : "";
}

std::string needs_locale(const Facts& facts) {
  return facts.locales.empty() ? "no locale with a decimal comma: apt-get install locales" : "";
}

std::string needs_interpreter(const Facts& facts) {
  return facts.has_interpreter ? "" : "no Python or Perl in the program";
}

std::string needs_time_namespace(const Facts& facts) {
  return facts.no_time_namespace;
}

std::string needs_user_namespace(const Facts& facts) {
  return facts.no_user_namespace;
}

std::string needs_process_namespace(const Facts& facts) {
  return facts.no_process_namespace;
}

std::string needs_cycle_counter(const Facts& facts) {
  if (!facts.is_x86_64) return "x86-64 only";
  return facts.no_shim.empty() ? facts.no_cycle_trap : facts.no_shim;
}

template <BuildKind kind>
std::string needs_build(const Facts& facts) {
  return facts.builds[static_cast<std::size_t>(kind)].missing;
}

std::string needs_libm_of_cpu(const Facts& facts) {
  if (!facts.is_x86_64) return "x86-64 only";
  return calls_made(facts, Group::libm, "does not call libm");
}

std::string needs_emulator(const Facts& facts) {
  if (!facts.is_x86_64) return "x86-64 only";
  return facts.emulator.empty() ? "no emulator: apt-get install qemu-user" : "";
}

std::string needs_math_library(const Facts& facts) {
  return facts.has_math_library ? "" : "no OpenBLAS, MKL or Python in the program";
}

// --- changes --------------------------------------------------------------------------------------------------------

void heap_fill(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr std::int32_t fills[] = {0xa5, 0x00, 0xff, shim::heap_fill_varied};
  conditions.settings.heap_fill = fills[variant];
}
void fix_heap(Conditions& conditions) {
  conditions.settings.heap_fill = 0;
}

void heap_order(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  conditions.settings.heap_order = 1 + variant;
}
void fix_addresses(Conditions& conditions) {
#ifdef __linux__
  conditions.process.personality |= ADDR_NO_RANDOMIZE;
#else
  static_cast<void>(conditions);
#endif
}

void heap_alignment(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr std::uint32_t alignments[] = {16, 32, 64};
  conditions.settings.heap_alignment = alignments[variant];
}

void allocator(Conditions& conditions, unsigned variant, std::uint64_t, const Facts& facts) {
  conditions.has_shim = false;
  conditions.preload.push_back(facts.allocators[variant % facts.allocators.size()]);
}

void heap_tunables(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  conditions.has_shim = false;
  if (variant == 0)
    conditions.tunables = {"glibc.malloc.mmap_threshold=4096", "glibc.malloc.tcache_count=0"};
  else
    conditions.tunables = {"glibc.malloc.top_pad=1048576", "glibc.malloc.arena_max=1", "glibc.malloc.perturb=165"};
}

void address_layout(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
#ifdef __linux__
  conditions.process.personality |= variant == 0 ? ADDR_NO_RANDOMIZE : ADDR_COMPAT_LAYOUT;
#else
  static_cast<void>(conditions);
  static_cast<void>(variant);
#endif
}

void stack_fill(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  conditions.settings.stack_fill = variant == 0 ? 0xa5 : 0xff;
}
void fix_stack(Conditions& conditions) {
  conditions.settings.stack_fill = 0;
}

void environment(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr std::size_t size = 2048;
  if (variant == 0) {
    conditions.order = EnvironmentOrder::reversed;
    conditions.environment.emplace_back("TICKTRUE_ADDED", std::string(size, 'x'));
  } else {
    for (const char* name : {"HOME", "USER", "LOGNAME", "DISPLAY", "TERM", "SHELL"})
      conditions.environment.emplace_back(name, std::nullopt);
  }
}

void locale(Conditions& conditions, unsigned variant, std::uint64_t, const Facts& facts) {
  const std::string& name = facts.locales[variant % facts.locales.size()];
  conditions.environment.emplace_back("LC_ALL", name);
  conditions.environment.emplace_back("LANG", name);
  if (!facts.locale_folder.empty()) conditions.environment.emplace_back("LOCPATH", facts.locale_folder);
}
void fix_locale(Conditions& conditions) {
  conditions.environment.emplace_back("LC_ALL", "C");
}

void time_zone(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  conditions.environment.emplace_back("TZ", variant == 0 ? "TKA-12:45" : "TKB+11:30");
}
void fix_time_zone(Conditions& conditions) {
  conditions.environment.emplace_back("TZ", "UTC0");
}

void date(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr std::int64_t offsets[] = {123 * day_s + 4567, 14 * year_s + 789, -9 * year_s};
  conditions.settings.clock_mode = 1;
  conditions.settings.realtime_offset_s = offsets[variant];
}

void uptime(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr std::int64_t offsets[] = {86461, 400 * day_s};
  conditions.settings.clock_mode = 1;
  conditions.settings.monotonic_offset_s = offsets[variant];
}

void time_namespace(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.has_shim = false;
  conditions.wrapper = time_wrapper();
}

void clock_rate(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr double rates[] = {7, 0.5};
  conditions.settings.clock_mode = 1;
  conditions.settings.clock_rate = rates[variant];
}
void fix_clock(Conditions& conditions) {
  conditions.settings.clock_mode = 2;
}

void random_bytes(Conditions& conditions, unsigned, std::uint64_t seed, const Facts&) {
  conditions.settings.random_mode = 1;
  conditions.settings.seed = seed;
}
void fix_random(Conditions& conditions) {
  conditions.settings.random_mode = 1;
  conditions.settings.seed = 1;
}

void rand_draws(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.settings.rand_mode = 2;
}
void rand_library(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.settings.rand_mode = 1;
}

void directory_order(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  conditions.settings.directory_mode = 1 + variant;
}
void fix_directory(Conditions& conditions) {
  conditions.settings.directory_mode = 2;
}

void hash_seed(Conditions& conditions, unsigned variant, std::uint64_t seed, const Facts&) {
  conditions.environment.emplace_back("PYTHONHASHSEED", std::to_string(1 + variant + seed * 7));
  conditions.environment.emplace_back("PERL_HASH_SEED", std::to_string(1 + variant + seed * 7));
}
void fix_hash_seed(Conditions& conditions) {
  conditions.environment.emplace_back("PYTHONHASHSEED", "0");
  conditions.environment.emplace_back("PERL_HASH_SEED", "0");
}

void processors(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr std::uint32_t counts[] = {3, 1, 8};
  conditions.settings.processor_count = counts[variant];
}
void fix_processors(Conditions& conditions) {
  conditions.settings.processor_count = 1;
}

void one_cpu(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.process.on_one_cpu = true;
}
void fix_one_cpu(Conditions& conditions) {
  conditions.process.on_one_cpu = true;
}

void thread_start(Conditions& conditions, unsigned variant, std::uint64_t seed, const Facts&) {
  conditions.settings.thread_delay_us = variant == 0 ? 2000 : 50000;
  conditions.settings.seed = seed;
}

void fix_threads(Conditions& conditions) {
  conditions.settings.threads_in_turn = 1;
}

void lock_delay(Conditions& conditions, unsigned, std::uint64_t seed, const Facts&) {
  conditions.settings.lock_delay_us = 200;
  conditions.settings.seed = seed;
}

void working_folder(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.in_other_folder = true;
}
void stack_limit(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.process.has_unlimited_stack = true;
}
void file_limit(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.process.has_few_files = true;
}
void file_mode(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  constexpr int none_for_others = 077;
  conditions.process.umask = none_for_others;
}
void huge_pages(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  if (variant == 0)
    conditions.process.has_no_huge_pages = true;
  else
    conditions.tunables.push_back("glibc.malloc.hugetlb=1");
}
void output(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  (variant == 0 ? conditions.process.prints_to_null : conditions.process.prints_to_terminal) = true;
}

void host_name(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.settings.host_mode = 1;
}
void user(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.has_shim = false;
  conditions.wrapper = user_wrapper();
}
void process_id(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.has_shim = false;
  conditions.wrapper = process_wrapper();
}
void fix_process_id(Conditions& conditions) {
  conditions.settings.process_mode = 1;
}
void cycle_counter(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.settings.cycle_mode = 1;
}
void fix_cycle_counter(Conditions& conditions) {
  conditions.settings.cycle_mode = 2;
}

void libm_of_cpu(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.tunables.push_back("glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX2_Usable,-FMA_Usable");
}

void cpu_model(Conditions& conditions, unsigned variant, std::uint64_t, const Facts& facts) {
  constexpr const char* models[] = {"Nehalem", "Haswell", "max"};
  conditions.has_shim = false;
  conditions.wrapper = {facts.emulator, "-cpu", models[variant]};
  conditions.wrapper_reverses = true;  // as qemu does
}

void library_dispatch(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  (variant == 0 ? choose_oldest_kernels : leave_out_features)(conditions);
}

void libm_ulp(Conditions& conditions, unsigned variant, std::uint64_t seed, const Facts&) {
  conditions.settings.libm_mode = 1 + variant;
  conditions.settings.seed = seed;
}

void sort_ties(Conditions& conditions, unsigned, std::uint64_t, const Facts&) {
  conditions.settings.sort_mode = 1;
}

void flush_to_zero(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  constexpr std::uint32_t flush = 1;
  constexpr std::uint32_t keep = 4;
  conditions.settings.float_mode = variant == 0 ? flush : keep;
}

template <BuildKind kind>
void other_build(Conditions& conditions, unsigned, std::uint64_t, const Facts& facts) {
  conditions.program = facts.builds[static_cast<std::size_t>(kind)].program;
}

void rounding(Conditions& conditions, unsigned variant, std::uint64_t, const Facts&) {
  conditions.settings.float_mode = 2 + variant;
}

constexpr std::string_view own_order = "order by something of the game: an id, not an address";
constexpr std::string_view clock_mend = "let no clock reach the state: count ticks, take dt from begin_tick";
constexpr std::string_view random_mend = "keep a generator of your own in the state, and its seed in the setup";
constexpr std::string_view libm_mend =
    "use functions with the same bits everywhere: include/ticktrue/math.h, docs/math.md";
constexpr std::string_view build_mend =
    "compute what the language leaves open in one way: order of arguments, overflow, variables that nothing has set";
constexpr std::string_view fused_mend = "build with -ffp-contract=off for all players: docs/pitfalls.md";
constexpr std::string_view thread_mend = "let each thread write to a place of its own, and join in a fixed order";

constexpr bool by_shim = true;
constexpr bool by_launch = false;
constexpr bool together = true;
constexpr bool alone = false;
constexpr auto no_fix = nullptr;
constexpr auto whole = Narrowing::none;

constexpr Perturbation table[] = {
    {"heap_fill", Kind::a, "fresh and freed blocks of the heap hold other bytes",
     "initialise the memory, and read none that is freed", by_shim, together, Narrowing::calls, Group::heap, 4,
     needs_calls<Group::heap>, heap_fill, fix_heap},
    {"heap_order", Kind::a, "blocks of the heap lie at falling or scattered addresses", own_order, by_shim, together,
     Narrowing::calls, Group::heap, 2, needs_calls<Group::heap>, heap_order, no_fix},
    {"heap_alignment", Kind::a, "blocks of the heap are aligned to 16, 32 or 64 bytes and to no more",
     "align arrays yourself, or sum in one order for every alignment", by_shim, together, Narrowing::calls, Group::heap,
     3, needs_calls<Group::heap>, heap_alignment, no_fix},
    {"allocator", Kind::a, "another allocator: jemalloc, tcmalloc, mimalloc", own_order, by_launch, alone, whole,
     Group::heap, 3, needs_allocator, allocator, no_fix},
    {"heap_tunables", Kind::a, "other thresholds of the allocator of the C library", own_order, by_launch, alone, whole,
     Group::heap, 2, linux_only, heap_tunables, no_fix},
    {"address_layout", Kind::a, "addresses that are not random, or laid out the other way", own_order, by_launch, alone,
     whole, Group::heap, 2, linux_only, address_layout, fix_addresses},
    {"stack_fill", Kind::a, "the stack below the program holds other bytes", "initialise local variables and padding",
     by_shim, together, Narrowing::ticks, Group::heap, 2, shim_loaded, stack_fill, fix_stack},
    {"environment", Kind::a, "environment variables: another order, another size, no HOME",
     "read settings from the setup, not from the environment", by_launch, together, whole, Group::heap, 2, always,
     environment, no_fix},
    {"locale", Kind::a, "a locale with a decimal comma; Turkish letters",
     "do not call setlocale for numbers, or parse with std::from_chars", by_launch, together, whole, Group::heap, 2,
     needs_locale, locale, fix_locale},
    {"time_zone", Kind::a, "another time zone", "use UTC, or no calendar", by_launch, together, whole, Group::heap, 2,
     always, time_zone, fix_time_zone},
    {"date", Kind::a, "another date", clock_mend, by_shim, together, Narrowing::calls, Group::clock, 3,
     needs_calls<Group::clock>, date, fix_clock},
    {"uptime", Kind::a, "a machine that has run for longer", clock_mend, by_shim, together, Narrowing::calls,
     Group::clock, 2, needs_calls<Group::clock>, uptime, no_fix},
    {"time_namespace", Kind::a, "a machine that has run for longer, for every program and not through the C library",
     clock_mend, by_launch, alone, whole, Group::clock, 1, needs_time_namespace, time_namespace, no_fix},
    {"clock_rate", Kind::a, "clocks that go faster or slower", clock_mend, by_shim, together, Narrowing::calls,
     Group::clock, 2, needs_calls<Group::clock>, clock_rate, no_fix},
    {"hash_seed", Kind::a, "another hash seed of Python or Perl", "sort what comes out of a set or a hash", by_launch,
     together, whole, Group::heap, 2, needs_interpreter, hash_seed, fix_hash_seed},
    {"random", Kind::a, "other random bytes of the system", random_mend, by_shim, together, Narrowing::calls,
     Group::random, 2, needs_calls<Group::random>, random_bytes, fix_random},
    {"rand_draws", Kind::a, "someone else draws from rand, too", random_mend, by_shim, together, Narrowing::calls,
     Group::rand, 1, needs_calls<Group::rand>, rand_draws, no_fix},
    {"directory_order", Kind::a, "directories list their entries in another order", "sort the names", by_shim, together,
     Narrowing::calls, Group::directory, 3, needs_calls<Group::directory>, directory_order, fix_directory},
    {"processors", Kind::a, "another number of processors", "divide work by what there is to do, not by who does it",
     by_shim, together, Narrowing::calls, Group::processors, 3, needs_calls<Group::processors>, processors,
     fix_processors},
    {"one_cpu", Kind::a, "all threads on one processor", thread_mend, by_launch, alone, whole, Group::thread, 1,
     linux_only, one_cpu, fix_one_cpu},
    {"thread_start", Kind::a, "threads begin late", thread_mend, by_shim, together, Narrowing::calls, Group::thread, 2,
     needs_calls<Group::thread>, thread_start, fix_threads},
    {"lock_delay", Kind::a, "locks are taken late", thread_mend, by_shim, together, Narrowing::calls, Group::lock, 2,
     needs_calls<Group::lock>, lock_delay, no_fix},
    {"working_folder", Kind::a, "another working folder with the same files", "keep paths out of the state", by_launch,
     together, whole, Group::heap, 1, linux_only, working_folder, no_fix},
    {"stack_limit", Kind::a, "an unlimited stack, which moves the heap", own_order, by_launch, together, whole,
     Group::heap, 1, linux_only, stack_limit, no_fix},
    {"file_limit", Kind::a, "at most 128 open files", "close files, and keep limits out of the state", by_launch,
     together, whole, Group::heap, 1, linux_only, file_limit, no_fix},
    {"file_mode", Kind::a, "another umask", "keep file modes out of the state", by_launch, together, whole, Group::heap,
     1, linux_only, file_mode, no_fix},
    {"huge_pages", Kind::a, "with and without huge pages", own_order, by_launch, together, whole, Group::heap, 2,
     linux_only, huge_pages, no_fix},
    {"host_name", Kind::a, "another name of the machine", "keep the name of the machine out of the state", by_shim,
     together, Narrowing::calls, Group::identity, 1, needs_calls<Group::identity>, host_name, no_fix},
    {"user", Kind::a, "another user", "keep users and their names out of the state", by_launch, alone, whole,
     Group::identity, 1, needs_user_namespace, user, no_fix},
    {"process_id", Kind::a, "another process number", "keep process numbers out of the state and out of seeds",
     by_launch, alone, Narrowing::calls, Group::identity, 1, needs_process_namespace, process_id, fix_process_id},
    {"cycle_counter", Kind::a, "rdtsc of the processor counts from elsewhere", clock_mend, by_shim, alone,
     Narrowing::calls, Group::cycle_counter, 1, needs_cycle_counter, cycle_counter, fix_cycle_counter},
    {"output", Kind::a, "standard output goes nowhere, or to a terminal", "do not ask whether somebody looks",
     by_launch, together, whole, Group::heap, 2, needs_unread_output, output, no_fix},
    {"libm_of_cpu", Kind::b, "libm as on a processor without FMA and AVX2", libm_mend, by_launch, alone,
     Narrowing::libm_results, Group::libm, 1, needs_libm_of_cpu, libm_of_cpu, no_fix},
    {"cpu_model", Kind::b, "another processor, by emulation: Nehalem, Haswell, all that the emulator has", libm_mend,
     by_launch, alone, whole, Group::libm, 3, needs_emulator, cpu_model, no_fix},
    {"library_dispatch", Kind::b, "OpenBLAS, MKL, numpy and torch as on an older processor",
     "fix the kernels: OPENBLAS_CORETYPE, NPY_DISABLE_CPU_FEATURES, MKL_CBWR", by_launch, alone, Narrowing::dispatch,
     Group::libm, 2, needs_math_library, library_dispatch, no_fix},
    {"libm_ulp", Kind::b, "results of libm one ulp off, as of another library", libm_mend, by_shim, alone,
     Narrowing::calls, Group::libm, 3, needs_calls<Group::libm>, libm_ulp, no_fix},
    {"sort_ties", Kind::b, "equal elements of qsort in the reverse order",
     "compare until nothing is equal, as by an id", by_shim, alone, Narrowing::calls, Group::sort, 1,
     needs_calls<Group::sort>, sort_ties, no_fix},
    {"rand_library", Kind::b, "rand of another C library", random_mend, by_shim, alone, Narrowing::calls, Group::rand,
     1, needs_calls<Group::rand>, rand_library, no_fix},
    {"flush_to_zero", Kind::b, "denormal numbers become zero, or are kept, as a library may set it",
     "set the float environment in each thread, or keep clear of denormals", by_shim, alone, Narrowing::ticks,
     Group::libm, 2, needs_other_program, flush_to_zero, no_fix},
    {"other_compiler", Kind::b, "the program, built by another compiler", build_mend, by_launch, alone, whole,
     Group::libm, 1, needs_build<BuildKind::other_compiler>, other_build<BuildKind::other_compiler>, no_fix},
    {"no_optimisation", Kind::b, "the program, built with -O0", build_mend, by_launch, alone, whole, Group::libm, 1,
     needs_build<BuildKind::no_optimisation>, other_build<BuildKind::no_optimisation>, no_fix},
    {"contraction", Kind::b, "the program, built with products and sums in one (FMA)", fused_mend, by_launch, alone,
     whole, Group::libm, 1, needs_build<BuildKind::contraction>, other_build<BuildKind::contraction>, no_fix},
    {"this_processor", Kind::b, "the program, built with -O3 for this processor", fused_mend, by_launch, alone, whole,
     Group::libm, 1, needs_build<BuildKind::this_processor>, other_build<BuildKind::this_processor>, no_fix},
    {"rounding", Kind::c, "another rounding mode", "set the rounding mode in each thread", by_shim, alone,
     Narrowing::ticks, Group::libm, 2, needs_other_program, rounding, no_fix},
};

}  // namespace

std::span<const Perturbation> perturbations() {
  return table;
}

const Perturbation* find_perturbation(std::string_view name) {
  const auto found =
      std::find_if(std::begin(table), std::end(table), [&](const Perturbation& row) { return row.name == name; });
  return found == std::end(table) ? nullptr : found;
}

}  // namespace ticktrue::shake
