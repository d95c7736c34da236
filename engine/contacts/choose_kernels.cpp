// The choice of kernels by instruction set and by the features of the scene's contacts.
// SPDX-License-Identifier: MIT
#include "engine/contacts/choose_kernels.h"

#include "engine/model/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

unsigned contact_features(const Model& model) {
  unsigned features = 0;
  for (const BodyModel& body : model.bodies)
    for (std::uint32_t child = 0; child < body.shape_count; ++child) {
      const ShapeModel& shape = model.shape(body, child);
      if (shape.is_sensor || model.is_non_colliding[body.first_shape + child] != 0) continue;
      if (shape.friction > 0) features |= contact_feature::friction;
      if (shape.radius > 0) features |= contact_feature::radius;
      // A contact with a circle has one point. A contact of two other shapes has two, if one of the shapes is dynamic.
      const bool moves = body.type == BodyType::dynamic_body;
      if (moves && shape.family != ShapeFamily::circle) features |= contact_feature::second_point;
    }
  if (model.bounces) features |= contact_feature::bounce;
  if (model.has_surfaces) features |= contact_feature::surface;
  return features;
}

std::string left_out(unsigned features) {
  std::string text;
  const auto add = [&text](bool is_out, std::string_view what) {
    if (is_out) text += (text.empty() ? "" : ", ") + std::string(what);
  };
  if ((features & contact_feature::surface) != 0) return text;
  add((features & contact_feature::friction) == 0, "no friction");
  add((features & contact_feature::second_point) == 0, "one point");
  add((features & contact_feature::radius) == 0, "no round shape");
  add((features & contact_feature::bounce) == 0, "no restitution");
  return text;
}

void set_kernels(Model& model, InstructionSet set, unsigned features) {
  if ((features & contact_feature::surface) != 0) features = contact_feature::all;  // the kernel with surfaces has all
  model.contact_features = features;
  model.kernels = {baseline::filling_kernels(),  baseline::contact_kernels(features),
                   baseline::revolute_kernels(), baseline::driven_revolute_kernels(),
                   baseline::motion_kernels(),   baseline::box_kernels()};
#if defined(TICKTRUE_HAS_AVX2_KERNELS)
  if (set == InstructionSet::avx2)
    model.kernels = {avx2::filling_kernels(),         avx2::contact_kernels(features), avx2::revolute_kernels(),
                     avx2::driven_revolute_kernels(), avx2::motion_kernels(),          avx2::box_kernels()};
#endif
  static_cast<void>(set);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
