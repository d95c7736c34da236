// Scenes in binary: one writer and one reader, next to each other.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_binary.h"

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "base/limits.h"
#include "engine/scene/scene_fields.h"

namespace ticktrue::engine {
namespace {

// Versions of this encoding alone. docs/engine_setup.md defines each byte. A scene is written in the first version that
// can represent it, so that its bytes equal those of older programs.
constexpr std::uint16_t first_version = 2;
constexpr std::uint16_t last_version = 6;

/// The first version with all kinds of the joints, and all fields of the settings that differ from their defaults.
std::uint16_t version_of(const Scene& scene) {
  std::uint16_t version = first_version;
  const Settings unset;
  visit_fields(
      [&](const FieldInfo& field, const auto& value, const auto& default_value) {
        if (field.since > version && !same_bits(value, default_value)) version = field.since;
      },
      scene.settings, unset);
  for (const Joint& joint : scene.joints)
    if (traits_of(joint.kind).since > version) version = traits_of(joint.kind).since;
  return version;
}

// Whether a field that only some kinds have is stored. Joints of every kind store all fields up to `collide_connected`.
bool is_stored(const Joint& joint, JointField field) {
  return field <= JointField::collide_connected || has_field(joint.kind, field);
}
bool is_stored(const Shape& shape, ShapeField field) {
  return !key_of(info_of(shape_kinds, shape.kind), field).empty();
}
bool is_stored(const JointSpring& spring, bool absolute) {
  return absolute == spring.absolute;
}
bool is_stored(const Force&, ForceField) {
  return true;
}
bool is_stored(const ClockSettings&, ClockField) {
  return true;
}

/// The row of a struct whose kinds have no rows.
struct NoRow {
  std::array<FieldKey<bool>, 0> keys;
};

class SceneWriter {
 public:
  void write(const Scene& scene) {
    version_ = version_of(scene);
    out_.u16(version_);
    write_fields(scene);
  }

  void write(bool value) { out_.u8(value ? 1 : 0); }
  void write(int value) { out_.i32(value); }
  void write(std::uint32_t value) { out_.u32(value); }
  void write(double value) { out_.f64(value); }
  void write(const std::string& value) { out_.text(value); }
  void write(const Point& value) {
    write(value.x);
    write(value.y);
  }
  void write(const Range& value) {
    write(value.lower);
    write(value.upper);
  }
  void write(const Shape& shape) {
    write(shape.kind);
    write_fields(shape);
    write_own_fields(shape);
  }
  void write(const JointSpring& spring) {
    write(spring.absolute);
    write_own_fields(spring);
  }
  void write(const Joint& joint) {
    write_fields(joint);
    write(joint.kind);
    write_own_fields(joint);
  }
  void write(const Force& force) {
    write_fields(force);
    write(force.kind);
    write_own_fields(force);
  }
  void write(const ClockSettings& clock) {
    write(clock.kind);
    write_own_fields(clock);
  }
  template <typename Value>
  void write(const std::optional<Value>& value) {
    write(value.has_value());
    if (value) write(*value);
  }
  template <typename Value>
  void write(const std::vector<Value>& values) {
    out_.u32(static_cast<std::uint32_t>(values.size()));
    for (const Value& value : values) write(value);
  }
  /// Writes a kind, or a struct of fields.
  template <typename Value>
  void write(const Value& value) {
    if constexpr (std::is_enum_v<Value>)
      out_.u8(static_cast<std::uint8_t>(value));
    else
      write_fields(value);
  }

  Bytes take() { return out_.take(); }

 private:
  template <typename Struct>
  void write_fields(const Struct& object) {
    visit_fields(
        [&](const FieldInfo& field, const auto& value) {
          if (field.since <= version_) write(value);
        },
        object);
  }
  template <typename Struct>
  void write_own_fields(const Struct& object) {
    visit_own_fields(
        [&](const auto& field, const auto& value) {
          if (is_stored(object, field.own)) write(value);
        },
        object);
  }

  ByteWriter out_;
  std::uint16_t version_ = first_version;
};

/// Size of an element with every field unset, in bytes. A count that could not fit is refused before memory is
/// reserved.
template <typename Value>
std::size_t size_min() {
  static const std::size_t size = [] {
    SceneWriter writer;
    writer.write(Value{});
    return writer.take().size();
  }();
  return size;
}

/// Reads the output of SceneWriter. Stores the first error; later reads give zeros, and lists end.
class SceneReader {
 public:
  explicit SceneReader(ByteView bytes) : in_(bytes) {}

  Result<Scene> read() {
    version_ = in_.u16();
    if (in_.ok() && (version_ < first_version || version_ > last_version))
      return Error{ErrorCode::incompatible,
                   "setup: unknown encoding of the scene: found version " + std::to_string(version_) + ", expected " +
                       std::to_string(first_version) + ".." + std::to_string(last_version),
                   "use a newer ticktrue"};
    Scene scene;
    read_fields(scene);
    if (in_.ok() && version_ != version_of(scene)) in_.fail();  // equal scenes have equal bytes

    if (!limit_message_.empty()) return Error{ErrorCode::limit, limit_message_, ""};
    if (!in_.ok())
      return Error{ErrorCode::corrupt, "setup: the scene in it cannot be read: it ends early or holds an unknown value",
                   ""};
    if (!in_.at_end())
      return Error{ErrorCode::corrupt,
                   "setup: bytes left over after the scene: found " + std::to_string(in_.remaining()) + ", expected 0",
                   ""};
    if (Status status = check_scene(scene, "setup"); !status) return status.error();
    return scene;
  }

 private:
  template <typename Table, typename Kind>
  void read_kind(const Table& table, Kind& kind) {
    const std::uint8_t value = in_.u8();
    if (value >= table.size()) return in_.fail();
    kind = static_cast<Kind>(value);
  }
  void read(bool& value) {
    const std::uint8_t byte = in_.u8();
    if (byte > 1) in_.fail();
    value = in_.ok() && byte == 1;
  }
  void read(int& value) { value = in_.i32(); }
  void read(std::uint32_t& value) { value = in_.u32(); }
  void read(double& value) { value = in_.f64(); }
  void read(std::string& value) { value = in_.text(limits::name_size_max); }
  void read(InputKind& value) { read_kind(input_kinds, value); }
  void read(Point& value) {
    read(value.x);
    read(value.y);
  }
  void read(Range& value) {
    read(value.lower);
    read(value.upper);
  }
  void read(Shape& shape) {
    read_kind(shape_kinds, shape.kind);
    read_fields(shape);
    read_own_fields(shape, info_of(shape_kinds, shape.kind));
  }
  void read(JointSpring& spring) {
    read(spring.absolute);
    read_own_fields(spring, NoRow{});
  }
  void read(Joint& joint) {
    read_fields(joint);
    read_kind(joint_kinds, joint.kind);
    read_own_fields(joint, info_of(joint_kinds, joint.kind));
  }
  void read(Force& force) {
    read_fields(force);
    read_kind(force_kinds, force.kind);
    read_own_fields(force, info_of(force_kinds, force.kind));
  }
  void read(ClockSettings& clock) {
    read_kind(clock_kinds, clock.kind);
    read_own_fields(clock, info_of(clock_kinds, clock.kind));
  }
  template <typename Value>
  void read(std::optional<Value>& value) {
    bool is_there = false;
    read(is_there);
    if (is_there) read(value.emplace());
  }
  /// Reads a kind, or a struct of fields.
  template <typename Value>
  void read(Value& value) {
    if constexpr (std::is_enum_v<Value>)
      read_kind(Tables::of(value), value);
    else
      read_fields(value);
  }
  /// Reads a count. A count that cannot fit gives zero and a failed reader.
  std::size_t count(std::size_t max, std::size_t size_min) {
    const std::uint32_t value = in_.u32();
    if (value > max && limit_message_.empty() && in_.ok())
      limit_message_ = "setup: offset " + std::to_string(in_.offset()) + ": too many: found " + std::to_string(value) +
                       ", expected at most " + std::to_string(max);
    if (value > max || value > in_.remaining() / size_min) in_.fail();
    return in_.ok() ? value : 0;
  }

  template <typename Value>
  void read(Value& value, const FieldRange&) {
    read(value);
  }
  template <typename Value>
  void read(std::vector<Value>& values, const FieldRange& range) {
    values.resize(count(static_cast<std::size_t>(range.max), size_min<Value>()));
    for (Value& value : values) read(value);
  }
  template <typename Struct>
  void read_fields(Struct& object) {
    visit_fields(
        [&](const FieldInfo& field, auto& value) {
          if (field.since <= version_) read(value, field.range);
        },
        object);
  }
  template <typename Struct, typename Row>
  void read_own_fields(Struct& object, const Row& row) {
    visit_own_fields(
        [&](const auto& field, auto& value) {
          if (is_stored(object, field.own)) read(value, range_of(row, field.own, field.range));
        },
        object);
  }

  ByteReader in_;
  std::uint16_t version_ = first_version;
  std::string limit_message_;
};

}  // namespace

Bytes encode_scene(const Scene& scene) {
  SceneWriter writer;
  writer.write(scene);
  return writer.take();
}

Result<Scene> decode_scene(ByteView bytes) {
  if (bytes.size() > limits::setup_size_max)
    return Error{ErrorCode::limit,
                 "setup: too large: found " + std::to_string(bytes.size()) + " bytes, expected at most " +
                     std::to_string(limits::setup_size_max),
                 ""};
  return SceneReader(bytes).read();
}

}  // namespace ticktrue::engine
