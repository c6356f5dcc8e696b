// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/material_map.h"

#include "common/failure.h"
#include "geometry/point.h"
#include "io/raster.h"

#include <cmath>

namespace crackle::ensemble {

namespace {

constexpr double rounding = 1e-6;  // of material numbers

}  // namespace

void apply_material_map(const input::Model& model, const geometry::Body& body, std::uint64_t sample,
                        geometry::Realization& realization) {
  if (!model.map) return;
  const io::Raster raster(*model.map, sample, body.bounds());
  const bool is_material = model.map->of == input::MapOf::material;
  for (const geometry::Tetrahedron& t : realization.tetrahedra) {
    const geometry::Point place = geometry::centroid(realization.nodes, t);
    const double value = raster.at(place);
    const auto refuse = [&](const char* wanted) {
      fail("{}: the value {:g} at ({:.4g}, {:.4g}, {:.4g}) mm is {}", raster.file().string(), value,
           1e3 * place[0], 1e3 * place[1], 1e3 * place[2], wanted);
    };
    if (is_material) {
      const double number = std::round(value);
      if (!(std::abs(value - number) < rounding && number >= 0 &&
            number < static_cast<double>(model.materials.size())))
        refuse("not the number of a [[material]]");
      realization.material.push_back(static_cast<std::uint8_t>(number));
    } else {
      const auto factor = static_cast<float>(value);
      if (!(factor > 0 && std::isfinite(factor))) refuse("not a factor; give values above 0");
      realization.map_factor.push_back(factor);
    }
  }
  if (!is_material || model.interfaces.empty()) return;
  realization.interface = geometry::interface_numbers(realization, model.interface_pairs());
}

void check_material_map(const std::optional<input::MaterialMap>& map, const geometry::Body& body) {
  if (map) io::Raster(*map, 0, body.bounds());
}

}  // namespace crackle::ensemble
