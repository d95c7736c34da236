// Reads the modules of the dynamic linker. Variables are read from .symtab, else from .dynsym.
// SPDX-License-Identifier: MIT
#include "capi/unsaved/memory.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "base/compiler/compiler.h"

#ifdef __GLIBC__
#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>

/// In the preload library, if it is loaded.
extern "C" TICKTRUE_WEAK void ticktrue_shim_heap(ticktrue::shim::KeptHeap* found,
                                                 const ticktrue::shim::KeptHeap* wanted);
#endif

namespace ticktrue::capi {

#ifdef __GLIBC__
namespace {

constexpr std::uint64_t range_size_max = std::uint64_t{256} << 20;

constexpr std::uint64_t generator_size = 128;  // bytes of the initial state of rand and random in the C library

/// Libraries whose variables are not state of a game.
bool is_foreign(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  for (const char* beginning : {"libc.so", "libc-", "libm.so", "libstdc++", "libgcc_s", "ld-linux", "libdl", "librt",
                                "libpthread", "libc++", "libticktrue", "linux-vdso", "libasan", "libubsan", "libzstd"})
    if (name.compare(0, std::strlen(beginning), beginning) == 0) return true;
  return false;
}

/// The bytes of a file, closed by the destructor.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat facts {};
    if (file >= 0 && ::fstat(file, &facts) == 0 && facts.st_size > 0) {
      size_ = static_cast<std::uint64_t>(facts.st_size);
      void* at = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
      data_ = at == MAP_FAILED ? nullptr : static_cast<const char*>(at);
    }
    if (file >= 0) ::close(file);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile() {
    if (data_ != nullptr) ::munmap(const_cast<char*>(data_), size_);
  }

  /// `count` structs at `offset`; null: they are outside the file.
  template <typename T>
  const T* at(std::uint64_t offset, std::uint64_t count = 1) const {
    if (data_ == nullptr || offset > size_ || count > (size_ - offset) / sizeof(T) || offset % alignof(T) != 0)
      return nullptr;
    return reinterpret_cast<const T*>(data_ + offset);
  }
  std::string text(std::uint64_t offset) const {
    constexpr std::uint64_t name_size_max = 4096;
    if (data_ == nullptr || offset >= size_) return "";
    return {data_ + offset, ::strnlen(data_ + offset, std::min(size_ - offset, name_size_max))};
  }

 private:
  const char* data_ = nullptr;
  std::uint64_t size_ = 0;
};

struct ModulePlace {
  std::uint64_t base = 0;
  std::uint64_t thread_begin = 0;  // the variables of this thread; 0: none
};

bool is_of_ticktrue(const std::string& name) {
  return name.compare(0, 12, "_ZN8ticktrue") == 0 || name.compare(0, 13, "_ZZN8ticktrue") == 0 ||
         name.compare(0, 13, "_ZGVN8ticktru") == 0;
}

void read_variables(const std::string& path, const ModulePlace& place, std::vector<Variable>& variables) {
  const MappedFile file(path);
  const auto* header = file.at<ElfW(Ehdr)>(0);
  if (header == nullptr || std::memcmp(header->e_ident, ELFMAG, SELFMAG) != 0) return;
  const auto* sections = file.at<ElfW(Shdr)>(header->e_shoff, header->e_shnum);
  if (sections == nullptr) return;
  const ElfW(Shdr)* table = nullptr;
  for (const ElfW(Word) wanted : {ElfW(Word){SHT_SYMTAB}, ElfW(Word){SHT_DYNSYM}})
    for (unsigned i = 0; table == nullptr && i < header->e_shnum; ++i)
      if (sections[i].sh_type == wanted) table = &sections[i];
  if (table == nullptr || table->sh_link >= header->e_shnum) return;
  const std::uint64_t count = table->sh_size / sizeof(ElfW(Sym));
  const auto* symbols = file.at<ElfW(Sym)>(table->sh_offset, count);
  for (std::uint64_t i = 0; symbols != nullptr && i < count; ++i) {
    const ElfW(Sym)& symbol = symbols[i];
    const unsigned type = symbol.st_info & 0xf;
    if ((type != STT_OBJECT && type != STT_TLS) || symbol.st_size == 0 || symbol.st_shndx == SHN_UNDEF) continue;
    if (type == STT_TLS && place.thread_begin == 0) continue;
    Variable variable;
    variable.address = symbol.st_value + (type == STT_TLS ? place.thread_begin : place.base);
    variable.size = symbol.st_size;
    variable.name = file.text(sections[table->sh_link].sh_offset + symbol.st_name);
    if (!is_of_ticktrue(variable.name)) variables.push_back(std::move(variable));
  }
}

void add_range(ProgramMemory& memory, const MemoryRange& range) {
  if (range.size == 0) return;
  if (range.size > range_size_max)
    memory.left_out += range.size;
  else
    memory.ranges.push_back(range);
}

std::string path_of(const dl_phdr_info& info) {
  if (info.dlpi_name != nullptr && info.dlpi_name[0] != 0) return info.dlpi_name;
  std::error_code failed;
  return std::filesystem::read_symlink("/proc/self/exe", failed).string();
}

int add_module(dl_phdr_info* info, std::size_t, void* with) {
  auto& memory = *static_cast<ProgramMemory*>(with);
  const std::string path = path_of(*info);
  if (path.empty() || is_foreign(path)) return 0;
  const std::size_t module = memory.modules.size();
  ModulePlace place{info->dlpi_addr, 0};
  std::uint64_t constant_end = 0;  // end of the part that the dynamic linker made read-only
  for (unsigned i = 0; i < info->dlpi_phnum; ++i)
    if (info->dlpi_phdr[i].p_type == PT_GNU_RELRO)
      constant_end = info->dlpi_phdr[i].p_vaddr + info->dlpi_phdr[i].p_memsz;
  for (unsigned i = 0; i < info->dlpi_phnum; ++i) {
    const ElfW(Phdr)& segment = info->dlpi_phdr[i];
    if (segment.p_type == PT_TLS && info->dlpi_tls_data != nullptr) {
      place.thread_begin = reinterpret_cast<std::uint64_t>(info->dlpi_tls_data);
      add_range(memory, {RangeKind::thread, place.thread_begin, segment.p_memsz, module});
    }
    if (segment.p_type != PT_LOAD || (segment.p_flags & PF_W) == 0) continue;
    const std::uint64_t end = segment.p_vaddr + segment.p_memsz;
    std::uint64_t begin = segment.p_vaddr;
    if (constant_end > begin && constant_end <= end) begin = constant_end;
    add_range(memory, {RangeKind::module, info->dlpi_addr + begin, end - begin, module});
  }
  std::uint64_t module_end = 0;
  for (unsigned i = 0; i < info->dlpi_phnum; ++i)
    if (info->dlpi_phdr[i].p_type == PT_LOAD)
      module_end = std::max<std::uint64_t>(module_end, info->dlpi_phdr[i].p_vaddr + info->dlpi_phdr[i].p_memsz);
  memory.modules.push_back({path, info->dlpi_addr, info->dlpi_addr + module_end});
  read_variables(path, place, memory.variables);
  return 0;
}

std::uint64_t stack_end() {
  pthread_attr_t facts;
  if (::pthread_getattr_np(::pthread_self(), &facts) != 0) return 0;
  void* begin = nullptr;
  std::size_t size = 0;
  const bool is_known = ::pthread_attr_getstack(&facts, &begin, &size) == 0;
  ::pthread_attr_destroy(&facts);
  return is_known ? reinterpret_cast<std::uint64_t>(begin) + size : 0;
}

}  // namespace

ProgramMemory program_memory(const void* stack_begin) {
  ProgramMemory memory;
  ::dl_iterate_phdr(add_module, &memory);
  const auto begin = reinterpret_cast<std::uint64_t>(stack_begin) / 8 * 8;
  const std::uint64_t end = stack_end();
  const ParkedGenerator generator;
  if (generator.address() != 0) add_range(memory, {RangeKind::generator, generator.address(), generator_size, 0});
  if (begin != 0 && begin < end) add_range(memory, {RangeKind::stack, begin, end - begin, 0});
  std::sort(memory.variables.begin(), memory.variables.end(), [](const Variable& a, const Variable& b) {
    return a.address != b.address ? a.address < b.address : a.size > b.size;
  });
  return memory;
}

// Source: initstate(3). A state that is replaced also stores its position.
ParkedGenerator::ParkedGenerator() : state_(::initstate(1, other_, sizeof other_)) {}
ParkedGenerator::~ParkedGenerator() {
  if (state_ != nullptr) ::setstate(state_);
}
std::uint64_t ParkedGenerator::address() const {
  Dl_info info{};
  const bool is_known = state_ != nullptr && ::dladdr(state_, &info) != 0 && info.dli_fname != nullptr;
  return is_known && is_foreign(info.dli_fname) ? reinterpret_cast<std::uint64_t>(state_) : 0;
}

shim::KeptHeap kept_heap() {
  shim::KeptHeap heap{};
  if (ticktrue_shim_heap != nullptr) ticktrue_shim_heap(&heap, nullptr);
  return heap;
}

void keep_heap_blocks(const shim::KeptHeap& from) {
  shim::KeptHeap wanted = from;
  wanted.has_reuse = 0;
  if (ticktrue_shim_heap != nullptr) ticktrue_shim_heap(nullptr, &wanted);
}

std::size_t thread_count() {
  std::error_code failed;
  std::size_t count = 0;
  for (std::filesystem::directory_iterator at("/proc/self/task", failed), end; !failed && at != end;
       at.increment(failed))
    ++count;
  return count;
}

#else

ProgramMemory program_memory(const void*) {
  return {};
}
shim::KeptHeap kept_heap() {
  return {};
}
void keep_heap_blocks(const shim::KeptHeap&) {}
ParkedGenerator::ParkedGenerator() = default;
ParkedGenerator::~ParkedGenerator() = default;
std::uint64_t ParkedGenerator::address() const {
  return 0;
}
std::size_t thread_count() {
  return 1;
}

#endif

}  // namespace ticktrue::capi
