// Implements skywave probe join: photographs of a mirror ball from several sides become one map.
#include <fmt/format.h>

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "base/files.h"
#include "cli/print.h"
#include "cli/probe/commands.h"
#include "lights/probe/join_views.h"

namespace skywave {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

struct JoinFlags {
  std::vector<std::string> photographs;
  std::string output;
  double camera = 20;          // degrees
  std::optional<double> turn;  // degrees
  int height = 0;
  ReadLimits limits;
};

int JoinMain(const JoinFlags& flags) {
  CheckOutputs(std::array{flags.output}, flags.photographs);
  std::vector<BallView> views;
  for (const std::string& path : flags.photographs) {
    ProbeMap map = ReadProbe({path, Projection::kMirrorBall, flags.limits});
    views.push_back({path, std::move(map.image)});
  }
  JoinOptions options = {.camera = flags.camera * kRadians, .height = flags.height};
  if (flags.turn) options.turn = *flags.turn * kRadians;
  const JoinedViews joined = JoinViews(views, options);
  WriteImage(flags.output, joined.latlong);
  for (std::size_t i = 1; i < views.size(); ++i) {
    const PlacedView& view = joined.placed[i];
    const Vector3& up = view.map_from_view[2];
    Print(stdout,
          "{}  {:.2f} degrees to the right of the first, tilted by {:.2f}, times {:.3g} {:.3g} "
          "{:.3g}, correlation {:.3f}\n",
          views[i].name, AngleAround(view.map_from_view) / kRadians,
          AngleBetween(up, {0, 0, 1}) / kRadians, view.gain[0], view.gain[1], view.gain[2],
          view.agreement);
  }
  Print(stdout, "wrote {}: {} x {}\n", flags.output, joined.latlong.width, joined.latlong.height);
  if (joined.unseen > 0) {
    Print(stderr,
          "warning: {:.2f} % of the map are seen beside the cameras alone, which stay there: take "
          "views further apart, or lower --camera\n",
          100 * joined.unseen / (4 * std::numbers::pi));
  }
  return 0;
}

#define FIELD SKYWAVE_FIELD
std::vector<OptionOf<JoinFlags>> JoinOptionTable() {
  constexpr OptionMaker<JoinFlags> option = {};
  // clang-format off
  return {
    option({.name = "photographs", .help = "of a mirror ball, cropped to it, from two sides or more: EXR, HDR or PFM, as probe assemble makes them", .scope = OptionScope::kInput, .metavar = "BALL ...", .positional = true, .required = true, .most_values = 16}, FIELD(photographs), Texts("BALL")),
    option({.name = "camera", .help = "radius around the camera, as the ball shows it, of what other views replace [degrees]"}, FIELD(camera), Doubles(0.1, 90)),
    option({.name = "turn", .help = "how far the camera went around the ball from each view to the next, to its right, within 28 degrees, and tilted by no more [degrees]", .default_text = "anywhere"}, FIELD(turn), Doubles(-180, 180)),
    option({.name = "height", .help = "of the lat-long map, which is twice as wide", .default_text = "the resolution of the first view"}, FIELD(height), Numbers(1, 16384)),
    option({.name = "output", .help = "EXR, HDR or PFM", .letter = 'o', .required = true}, FIELD(output), Texts("FILE")),
    option({.name = "trust-input", .help = "decode rare kinds of EXR in this process, not in a confined one"}, FIELD(limits.trust_input), Switches()),
  };
  // clang-format on
}
#undef FIELD

}  // namespace

Command ProbeJoinCommand() {
  return CommandOf<JoinFlags>(
      {.name = "join",
       .summary = "A map without the camera from photographs of a mirror ball from several sides",
       .footer = "Example:\n"
                 "  skywave probe join ball-1.exr ball-2.exr -o sky.exr\n"
                 "  skywave probe join ball-1.exr ball-2.exr --turn 90 --camera 30 -o sky.exr"},
      JoinOptionTable(), JoinMain);
}

}  // namespace skywave
