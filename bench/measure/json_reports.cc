#include "bench/measure/json_reports.h"

#include <nlohmann/json.hpp>
#include <numbers>

#include "base/json.h"
#include "lights/maps/projections.h"

namespace skywave {

nlohmann::ordered_json Json(const ImageDifference& d, const Flip& flip) {
  return {{"mean_image", d.mean_a},
          {"mean_reference", d.mean_b},
          {"mse", d.mse},
          {"rmse", d.rmse},
          {"relative_mse", d.relative_mse},
          {"mean_absolute", d.mean_absolute},
          {"psnr_db", d.psnr},
          {"flip", flip.mean},
          {"squared_distance", 3 * d.mse},
          {"squared_channel_sum", d.squared_channel_sum},
          {"thesis_luminance", d.thesis_luminance},
          {"max_absolute", d.max_absolute},
          {"max_at", {d.max_x, d.max_y}},
          {"different_pixels", d.different_pixels}};
}

std::string JsonText(const ImageDifference& difference, const Flip& flip) {
  return JsonText(Json(difference, flip), 2);
}

nlohmann::ordered_json Json(const NoiseComparison& c) {
  return {{"mean_difference", c.mean_difference},
          {"half_width", c.half_width},
          {"exceeding", c.exceeding},
          {"mean_squared_z", c.mean_squared_z},
          {"values", c.values},
          {"exact_values", c.exact_values},
          {"exact_values_that_differ", c.exact_that_differ}};
}

std::string JsonText(const ProbeMap& map, const ProbeInfo& info) {
  const Strata& s = info.strata;
  const double pixels_per_sr = info.sphere_pixels / (4 * std::numbers::pi);
  nlohmann::ordered_json json;
  json["schema"] = "skywave-probe-info-1";
  json["width"] = map.image.width;
  json["height"] = map.image.height;
  json["projection"] = ToString(map.projection);
  json["projection_assumed"] = map.assumed;
  json["bad_pixels"] = {
      {"nan", map.bad.nan}, {"infinite", map.bad.infinite}, {"negative", map.bad.negative}};
  json["luminance"] = {{"least", info.least}, {"greatest", info.greatest}};
  json["mean_radiance"] = info.mean;
  json["energy"] = info.energy;
  json["table_7_1"] = {{"latlong", {info.width, info.height}},
                       {"sphere_area", info.sphere_pixels},
                       {"energy", info.energy_pixels},
                       {"zeta_minimum", info.zeta_minimum},
                       {"p", s.p},
                       {"threshold", s.texels_a ? s.threshold : 0},
                       {"texels_a", s.texels_a},
                       {"area_a", s.solid_angle_a * pixels_per_sr},
                       {"texels_b", s.texels_b},
                       {"area_b", s.solid_angle_b * pixels_per_sr},
                       {"energy_a", s.energy_a * pixels_per_sr},
                       {"energy_b", s.energy_b * pixels_per_sr}};
  for (const BrightSpot& spot : info.spots) {
    json["spots"].push_back({{"x", spot.x},
                             {"y", spot.y},
                             {"direction", {spot.direction.x, spot.direction.y, spot.direction.z}},
                             {"luminance", spot.luminance},
                             {"share", spot.share}});
  }
  return JsonText(json, 2);
}

}  // namespace skywave
