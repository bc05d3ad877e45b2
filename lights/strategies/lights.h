// The map as N directional lights: median-cut, variance-cut, penrose, polyomino (T 6.2, 6.3, 7.1),
// structured, k-means, kollig-keller (T 2.1).
//
// Every light carries the irradiance of its cell, so the lights have the energy of the map to
// rounding. Biased: shadows are those of N suns, and glossy surfaces reflect N points. Rays that
// BSDF sampling draws see no light, except those of camera, mirrors and glass, which see the map.
//
// Parameters
//   lights=64             number of lights, before clustering; auto:BIAS takes as many as have a
//                         relative bias of BIAS, 1e-4 to 1 (lights/light_sets/light_bias.h)
//   position=centroid     where a light stands in its cell: centroid of its energy, center of its
//                         area, or sample (the thesis)
//   longest=angle         sides that median cut compares: by angle on the sphere (Debevec), or uv,
//                         by their lengths in (u, v) (T 6.2)
//   lloyd=0               energy-weighted Lloyd steps (Kollig and Keller 2003)
//   cluster=none          F1, F2 or F3: merge lights pairwise (T 7.4.3), until
//   clusters=0            so many are left, and
//   separation=0          all are so many degrees apart
//   pick=all              all lights at every hit, or power: as many as the user asks light samples
//                         for, picked by their energy
#pragma once

#include "lights/light_sets/directional_lights.h"
#include "lights/light_sets/light_builder.h"
#include "lights/strategies/strategy.h"
#include "lights/tables/texels.h"

namespace skywave {

class LightsStrategy final : public EnvStrategy {
 public:
  LightsStrategy(std::string_view name, const EnvironmentMap& map, const LightOptions& options,
                 bool all)
      : LightsStrategy(name, map, BuildLights(MakeSphereMap(map.latlong), options), all) {}
  LightsStrategy(std::string_view name, const EnvironmentMap& map, const LightSet& lights,
                 bool all);

  std::string_view name() const override { return name_; }
  std::size_t table_bytes() const override { return texels_.bytes() + lights_.bytes(); }
  std::string note() const override { return note_; }
  bool shines_on_bsdf_samples() const override { return false; }
  bool unbiased() const override { return false; }
  LightPlan Plan(std::uint32_t requested) const override;
  void Sample(const ShadePoints& points, const UniformColumns& uniforms, std::uint32_t n,
              LightCall call, const LightColumns& out) const override;
  void EvaluateEscaped(const ShadePoints& points, std::uint32_t n, float samples,
                       const EscapeColumns& rows) const override;

 private:
  std::string_view name_;
  std::string note_;
  Texels texels_;  // black as a light
  DirectionalLights lights_;
  bool all_;
};

// The directional lights of a map, for strategies that hold them.
DirectionalLights MakeLights(const EnvironmentMap& map, const Image& part,
                             const LightOptions& options);

inline constexpr StrategyParameter kPickParameter = {
    "pick", "all", "all: every light at every hit; power: some, by their energy"};
bool ReadPickAll(const StrategyValues& values);

}  // namespace skywave
