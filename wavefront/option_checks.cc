#include "wavefront/option_checks.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "base/error.h"
#include "wavefront/bidirectional_tables.h"
#include "wavefront/option_names.h"
#include "wavefront/photons/photon_map.h"
#include "wavefront/photons/photon_pass.h"

namespace skywave {
namespace {

void CheckSplit(const RenderOptions& options) {
  if (options.split > 0 && options.integrator != Integrator::kPath) {
    throw InputError(
        InputPosition::File(fmt::format("--split {}", options.split)),
        fmt::format("splits paths: --integrator {} has none", ToString(options.integrator)),
        kExitUsage);
  }
}

// Of a pass: options.photons.indirect, or all that its light paths could leave.
std::uint64_t MostVertices(const RenderOptions& options) {
  const std::uint64_t samples = options.samples_per_pixel / PhotonPasses(options).size();
  const CropWindow film =
      WholeBlocks({options.crop_x, options.crop_y, options.width, options.height});
  const std::uint64_t paths = std::uint64_t(film.width) * std::uint64_t(film.height) * samples;
  return std::min<std::uint64_t>(options.photons.indirect, paths * options.max_depth);
}

// Of passes that store photons or light vertices.
void CheckPhotons(const RenderOptions& options) {
  const PhotonOptions& photons = options.photons;
  const auto refuse = [](const std::string& flag, const std::string& why) {
    throw InputError(InputPosition::File(flag), why, kExitUsage);
  };
  const bool merges = options.integrator == Integrator::kVcm;
  if (merges && photons.indirect == 0) {
    refuse("--photons 0",
           "--integrator vcm merges with light vertices, which are its photons; without them it is "
           "--integrator bdpt");
  }
  if (photons.indirect == 0 && photons.caustic == 0) {
    refuse("--photons 0 --caustic-photons 0",
           "--integrator photon needs photons; for direct light alone use --integrator direct");
  }
  if (photons.passes > options.samples_per_pixel) {
    refuse(fmt::format("--progressive {}", photons.passes),
           fmt::format("each pass needs a sample a pixel, and --spp is {}",
                       options.samples_per_pixel));
  }
  CheckPhotonMemory(options,
                    std::uint64_t(sysconf(_SC_PHYS_PAGES)) * std::uint64_t(sysconf(_SC_PAGESIZE)));
  if (Sums(options.aovs, AovSum::kDirect) || Sums(options.aovs, AovSum::kIndirect)) {
    refuse("--aovs " + ToString(options.aovs),
           "--integrator photon does not keep direct and indirect light apart");
  }
}

// What only makes sense of paths whose sub-paths are joined, and what does not of them.
void CheckBidirectional(const RenderOptions& options) {
  const bool joins = ConnectsSubpaths(options.integrator);
  if (options.subpath_lengths && options.integrator != Integrator::kBdpt) {
    throw InputError(InputPosition::File("--paths"),
                     fmt::format("shows single ways to join sub-paths, which --integrator {} does "
                                 "not; use bdpt",
                                 ToString(options.integrator)),
                     kExitUsage);
  }
  if (options.subpath_lengths &&
      (options.subpath_lengths->eye == 0 ||
       options.subpath_lengths->light + options.subpath_lengths->eye < 2 ||
       (options.subpath_lengths->light == 1 && options.subpath_lengths->eye == 1))) {
    throw InputError(InputPosition::File("--paths"),
                     "there are paths of light vertices S and eye vertices T, the eye counted, for "
                     "T >= 2, and for T = 1 and S >= 2",
                     kExitUsage);
  }
  if (options.subpath_lengths) {
    const std::uint64_t vertices =
        std::uint64_t(options.subpath_lengths->light) + options.subpath_lengths->eye;
    if (vertices - 2 > options.max_depth) {
      throw InputError(InputPosition::File("--paths"),
                       fmt::format("such paths scatter at {} surfaces, and --max-depth is {}",
                                   vertices - 2, options.max_depth),
                       kExitUsage);
    }
  }
  if (joins && !options.mis && !options.subpath_lengths) {
    throw InputError(
        InputPosition::File("--no-mis"),
        fmt::format("--integrator {} would add every path in all ways to make it; bdpt "
                    "with --paths S,T shows one way, unweighted",
                    ToString(options.integrator)),
        kExitUsage);
  }
  if (joins && options.max_depth > kMaxBidirectionalDepth) {
    throw InputError(InputPosition::File(fmt::format("--max-depth {}", options.max_depth)),
                     fmt::format("--integrator {} keeps a table a bounce, for at most {}",
                                 ToString(options.integrator), kMaxBidirectionalDepth),
                     kExitUsage);
  }
}

}  // namespace

void RefusePhotons(const RenderOptions& options, const std::string& why) {
  const PhotonOptions& photons = options.photons;
  const bool merges = options.integrator == Integrator::kVcm;
  const std::string caustic =
      merges ? std::string() : fmt::format(" --caustic-photons {}", photons.caustic);
  throw InputError(InputPosition::File(fmt::format("--photons {}{}", photons.indirect, caustic)),
                   why + "; ask for fewer", kExitUsage);
}

void CheckPhotonMemory(const RenderOptions& options, std::uint64_t memory) {
  const PhotonOptions& photons = options.photons;
  const bool merges = options.integrator == Integrator::kVcm;
  const std::uint64_t count =
      merges ? MostVertices(options) : std::uint64_t{photons.indirect} + photons.caustic;
  const std::uint64_t bytes = count * PhotonBytes(merges);
  constexpr double kGigabyte = 1e9;
  if (std::max(photons.indirect, photons.caustic) > kMostPhotons) {
    RefusePhotons(options, fmt::format("a map has room for {}", kMostPhotons));
  }
  if (bytes > memory) {
    RefusePhotons(options,
                  fmt::format("they take {:.1f} GB while maps are built, and there are {:.1f} GB",
                              double(bytes) / kGigabyte, double(memory) / kGigabyte));
  }
}

void CheckIntegrator(const RenderOptions& options) {
  const bool one_start =
      (options.integrator == Integrator::kPath || options.integrator == Integrator::kDirect) &&
      options.split == 0;
  if (Sums(options.aovs, AovSum::kLightGroups) && !one_start) {
    throw InputError(InputPosition::File("--aovs " + ToString(options.aovs)),
                     "light groups are kept by --integrator path, without --split, and direct",
                     kExitUsage);
  }
  CheckSplit(options);
  CheckBidirectional(options);
  if (HasPhotons(options.integrator)) CheckPhotons(options);
  if (HasSplats(options.integrator) &&
      (Sums(options.aovs, AovSum::kVariance) || Sums(options.aovs, AovSum::kDirect) ||
       Sums(options.aovs, AovSum::kIndirect))) {
    throw InputError(InputPosition::File("--aovs " + ToString(options.aovs)),
                     fmt::format("variance, direct and indirect are of samples of a pixel, which "
                                 "the splats of --integrator {} are not",
                                 ToString(options.integrator)),
                     kExitUsage);
  }
}

}  // namespace skywave
