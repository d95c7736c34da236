// Filling of batches from contacts, and storing of impulses: rows become lanes, several contacts at a time.
// SPDX-License-Identifier: MIT
//
// Consecutive numbers of a row are loaded together and transposed in registers. A vector load from lanes that were
// stored one by one would wait for the stores.
#include "engine/model/solver_kernels.h"
#include "engine/simd/realx2n.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

/// As many lanes of a batch as V has, from `first` on, up to the last filled lane.
template <typename V>
struct Filling {
  static constexpr int count = SimdTraits<V>::count;
  Filling(ContactBatch& batch_, FoundPoints& found_, int first_)
      : batch(batch_), found(found_), first(first_) {}  // other members are not initialized
  ContactBatch& batch;
  FoundPoints& found;
  int first;
  std::size_t pairs[count];  // places of the contacts' rows, bytes
  std::size_t rows[count];
  std::size_t masses_a[count];
  std::size_t masses_b[count];

  TICKTRUE_INLINE void store(ContactLanes& lanes, V value) const { SimdTraits<V>::store(lanes.at + first, value); }
};

template <typename T>
TICKTRUE_INLINE T* behind(T* first, std::size_t bytes) {
  return reinterpret_cast<T*>(reinterpret_cast<const unsigned char*>(first) + bytes);
}
TICKTRUE_INLINE Real* behind(Real* first, std::size_t bytes) {
  return reinterpret_cast<Real*>(reinterpret_cast<unsigned char*>(first) + bytes);
}

/// Gathers four consecutive numbers of each lane.
template <typename V>
TICKTRUE_INLINE Columns4<V> gather4_behind(const Real* first, const std::size_t* bytes) {
  Columns4<V> columns;
  const auto place = [&](int lane) { return behind(first, bytes[lane]); };
  if constexpr (SimdTraits<V>::count == 1)
    std::memcpy(columns.at, place(0), sizeof columns.at);
  else
    Transposer<Real, simd_width>::gather(place, columns.at);
  return columns;
}

/// The number of points of each contact. `normal`: the columns at ContactSource::normal; if the number is as wide as a
/// Real, they contain it. No lane then needs a load of its own.
template <typename V>
TICKTRUE_INLINE V point_counts(const ContactSource& source, const Filling<V>& lanes, const Columns4<V>& normal) {
  if constexpr (SimdTraits<V>::count == 1) {
    return static_cast<Real>(*behind(source.point_count, lanes.pairs[0]));
  } else {
    std::int32_t __attribute__((vector_size(simd_width * sizeof(std::int32_t)))) counts;
    if constexpr (sizeof counts == sizeof(V))
      std::memcpy(&counts, &normal.at[2], sizeof counts);
    else
      for (int i = 0; i < lanes.count; ++i) counts[i] = *behind(source.point_count, lanes.pairs[i]);
    return __builtin_convertvector(counts, V);
  }
}

/// Finds the rows of the lanes and the bodies of their contacts.
template <typename V>
TICKTRUE_INLINE void fill_places(const ContactSource& source, const std::uint32_t* slots, Filling<V>& out) {
  ContactBatch& batch = out.batch;
  for (int i = 0; i < out.count; ++i) {
    const std::uint32_t contact = slots[out.first + i];
    batch.contact[out.first + i] = contact;
    out.pairs[i] = contact * source.pair_size;
    out.rows[i] = contact * source.row_size;
    const std::uint32_t* bodies = behind(source.body_indices, out.pairs[i]);
    out.masses_a[i] = bodies[0] * source.mass_size;
    out.masses_b[i] = bodies[1] * source.mass_size;
    const std::uint32_t* records_a = behind(source.records, out.masses_a[i]);
    const std::uint32_t* records_b = behind(source.records, out.masses_b[i]);
    batch.read_a[out.first + i] = words_per_record * records_a[0];
    batch.read_b[out.first + i] = words_per_record * records_b[0];
    if (!has_sinks(batch)) continue;
    const auto write = [&](std::uint32_t record) {
      return words_per_record * (record == source.sink ? source.own_sink : record);
    };
    batch.write_a[out.first + i] = write(records_a[1]);
    batch.write_b[out.first + i] = write(records_b[1]);
  }
}

template <typename V>
TICKTRUE_INLINE void fill_lanes(const ContactSource& source, const std::uint32_t* slots, ContactBatch& batch,
                                FoundPoints& found, int first) {
  Filling<V> out(batch, found, first);
  fill_places(source, slots, out);
  const Columns4<V> a = gather4_behind<V>(source.masses, out.masses_a);
  out.store(batch.inv_mass_a, a.at[0]);
  out.store(batch.inv_inertia_a, a.at[1]);
  const Columns4<V> b = gather4_behind<V>(source.masses, out.masses_b);
  out.store(batch.inv_mass_b, b.at[0]);
  out.store(batch.inv_inertia_b, b.at[1]);
  const Columns4<V> surface = gather4_behind<V>(source.surface, out.pairs);
  out.store(batch.friction, surface.at[0]);
  out.store(batch.radius_a, surface.at[1]);
  out.store(batch.radius_b, surface.at[2]);
  const V slop = SimdTraits<V>::broadcast(source.slop) * surface.at[3];
  const Columns4<V> normal = gather4_behind<V>(source.normal, out.pairs);
  out.store(batch.normal_x, normal.at[0]);
  out.store(batch.normal_y, normal.at[1]);
  const Columns4<V> forces = gather4_behind<V>(source.forces, out.rows);
  const V counts = point_counts(source, out, normal);
  for (int p = 0; p < 2; ++p) {
    ContactPointLanes& point = batch.points[p];
    FoundPointLanes& found_point = found.points[p];
    const Columns4<V> anchors = gather4_behind<V>(source.anchors[p], out.pairs);
    const V zero{};
    const V exists = select(counts > SimdTraits<V>::broadcast(static_cast<Real>(p)), SimdTraits<V>::broadcast(1), zero);
    const auto set = [&](ContactLanes& lanes, V value) { out.store(lanes, select(exists > zero, value, zero)); };
    set(found_point.anchor_a_x, anchors.at[0]);
    set(found_point.anchor_a_y, anchors.at[1]);
    set(found_point.anchor_b_x, anchors.at[2]);
    set(found_point.anchor_b_y, anchors.at[3]);
    const V separation = select(exists > zero, gather4_behind<V>(source.separation[p], out.pairs).at[0] + slop, zero);
    out.store(point.separation, separation);
    out.store(point.present_separation, separation + zero);  // equals separation_of for bodies that have not moved
    set(found_point.normal_force, forces.at[p]);
    set(found_point.tangent_force, forces.at[2 + p]);
    out.store(found_point.exists, exists);
  }
}

/// An empty lane has no impulse and is written to a sink.
TICKTRUE_INLINE void empty_lane(const ContactSource& source, ContactBatch& batch, FoundPoints& found, int lane) {
  batch.read_a[lane] = batch.read_b[lane] = words_per_record * source.dummy;
  batch.write_a[lane] = batch.write_b[lane] = words_per_record * source.own_sink;
  batch.contact[lane] = 0;
  const auto empty = [&](ContactLanes& lanes) { lanes.at[lane] = 0; };
  empty(batch.inv_mass_a);
  empty(batch.inv_mass_b);
  empty(batch.inv_inertia_a);
  empty(batch.inv_inertia_b);
  empty(batch.normal_x);
  empty(batch.normal_y);
  empty(batch.friction);
  empty(batch.radius_a);
  empty(batch.radius_b);
  for (ContactPointLanes& point : batch.points) {
    empty(point.separation);
    empty(point.present_separation);
  }
  for (FoundPointLanes& point : found.points) {
    empty(point.anchor_a_x);
    empty(point.anchor_a_y);
    empty(point.anchor_b_x);
    empty(point.anchor_b_y);
    empty(point.exists);
    empty(point.normal_force);
    empty(point.tangent_force);
  }
}

/// Whether one body of a contact is not dynamic.
TICKTRUE_INLINE bool is_immovable(const ContactSource& source, std::uint32_t contact) {
  const std::uint32_t* bodies = behind(source.body_indices, contact * source.pair_size);
  return behind(source.records, bodies[0] * source.mass_size)[1] == source.sink ||
         behind(source.records, bodies[1] * source.mass_size)[1] == source.sink;
}

void fill(const ContactSource& source, ContactBatch* batches, FoundPoints* found, std::size_t batch_count,
          std::size_t slot_count) {
  for (std::size_t i = 0; i < batch_count; ++i) {
    ContactBatch& batch = batches[i];
    const std::uint32_t* slots = source.slots + i * contact_lane_count;
    int count = 0;
    while (count < contact_lane_count && slots[count] != no_contact) ++count;
    batch.count = count;
    batch.immovable = is_immovable(source, slots[0]) ? 1 : 0;
    batch.is_serial = source.is_serial[i];
    batch.bounces = 0;
    if (i + 1 < slot_count)  // prefetches the rows of the next batch: slots of a colour are not contiguous in memory
      for (int next = contact_lane_count; next < 2 * contact_lane_count; ++next) {
        const std::uint32_t contact = slots[next] != no_contact ? slots[next] : slots[0];
        __builtin_prefetch(behind(source.body_indices, contact * source.pair_size));
        __builtin_prefetch(behind(source.surface, contact * source.pair_size));
        __builtin_prefetch(behind(source.forces, contact * source.row_size));
      }
    int lane = 0;
    for (; lane + simd_width <= count; lane += simd_width) fill_lanes<RealxN>(source, slots, batch, found[i], lane);
    for (; lane < count; ++lane) fill_lanes<Real>(source, slots, batch, found[i], lane);
    if (batch.is_serial != 0) continue;
    for (; lane % lane_count != 0; ++lane) empty_lane(source, batch, found[i], lane);
  }
}

void store(const ContactBatch* batches, std::size_t count, Real* forces, std::size_t row_size, Real inv_h) {
  for (std::size_t i = 0; i < count; ++i) {
    const ContactBatch& batch = batches[i];
    const ContactPointLanes(&points)[2] = batch.points;
    int lane = 0;
    for (; lane + simd_width <= batch.count; lane += simd_width) {
      const auto force = [&](const ContactLanes& impulse) {  // + 0: as `stored`
        return broadcast(inv_h) * load_xn(impulse.at + lane) + RealxN{};
      };
      const RealxN columns[4] = {force(points[0].normal_impulse), force(points[1].normal_impulse),
                                 force(points[0].tangent_impulse), force(points[1].tangent_impulse)};
      Transposer<Real, simd_width>::scatter([&](int j) { return behind(forces, batch.contact[lane + j] * row_size); },
                                            columns);
    }
    for (; lane < batch.count; ++lane) {
      Real* row = behind(forces, batch.contact[lane] * row_size);
      for (int p = 0; p < 2; ++p) {
        row[p] = inv_h * points[p].normal_impulse.at[lane] + Real(0);
        row[2 + p] = inv_h * points[p].tangent_impulse.at[lane] + Real(0);
      }
    }
  }
}

}  // namespace

FillingKernels filling_kernels() {
  return {fill, store};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
