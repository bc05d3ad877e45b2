#include "lights/probe/export_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace skywave {
namespace {

constexpr double kPi = std::numbers::pi;

std::array<double, 3> TotalIrradiance(std::span<const DirectionalLight> lights) {
  std::array<double, 3> total = {};
  for (const DirectionalLight& light : lights) {
    for (int c = 0; c < 3; ++c) total[c] += light.irradiance[c];
  }
  return total;
}

double TotalEnergy(std::span<const DirectionalLight> lights) {
  double total = 0;
  for (const DirectionalLight& light : lights) total += light.energy;
  return total;
}

// An irradiance is split into a colour whose largest channel is 1 and a factor.
struct Split {
  double factor;
  std::array<double, 3> color;
};
Split SplitColor(const DirectionalLight& light) {
  const double factor = std::max({light.irradiance[0], light.irradiance[1], light.irradiance[2]});
  Split split = {factor, {}};
  for (int c = 0; c < 3; ++c) split.color[c] = factor > 0 ? light.irradiance[c] / factor : 0;
  return split;
}

// Quotes a file name as a string of the formats here, which all escape alike.
std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < 32 ? ' ' : c;
  }
  return quoted + "\"";
}

std::string OneLine(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  }
  return text;
}

std::string AxisName(const Vector3& axis) {
  const double value[3] = {axis.x, axis.y, axis.z};
  for (int i = 0; i < 3; ++i) {
    if (std::abs(value[i]) > 0.5) return fmt::format("{}{}", value[i] > 0 ? '+' : '-', "xyz"[i]);
  }
  return "?";
}

// Returns the comment at the top of every scene text.
std::string Header(std::span<const DirectionalLight> lights, const ExportOptions& options,
                   const WorldAxes& axes, std::string_view mark, std::string_view units) {
  const std::array<double, 3> total = TotalIrradiance(lights);
  std::string text;
  const auto line = [&](const std::string& words) { text += fmt::format("{} {}\n", mark, words); };
  line(
      fmt::format("skywave probe lights: {} lights of {}", lights.size(), OneLine(options.source)));
  line(fmt::format("axes of the map in this world: right {}, forward {}, up {}",
                   AxisName(axes.right), AxisName(axes.forward), AxisName(axes.up)));
  line(fmt::format("units: {}", units));
  line(fmt::format("total irradiance {:.9g} {:.9g} {:.9g}, luminance {:.9g}", total[0], total[1],
                   total[2], TotalEnergy(lights)));
  return text;
}

std::string Table(std::span<const DirectionalLight> lights) {
  std::string text =
      fmt::format("{:>5}  {:>10}{:>10}{:>10}  {:>13}{:>13}{:>13}{:>13}{:>12}\n", "#", "right",
                  "forward", "up", "E red", "E green", "E blue", "luminance", "area [sr]");
  int index = 0;
  for (const DirectionalLight& l : lights) {
    text += fmt::format(
        "{:>5}  {:>10.6f}{:>10.6f}{:>10.6f}  {:>13.6g}{:>13.6g}{:>13.6g}{:>13.6g}"
        "{:>12.4g}\n",
        index++, l.direction.x, l.direction.y, l.direction.z, l.irradiance[0], l.irradiance[1],
        l.irradiance[2], l.energy, l.solid_angle);
  }
  const std::array<double, 3> total = TotalIrradiance(lights);
  return text + fmt::format("{:>5}  {:>30}  {:>13.6g}{:>13.6g}{:>13.6g}{:>13.6g}\n", "total", "",
                            total[0], total[1], total[2], TotalEnergy(lights));
}

std::string Json(std::span<const DirectionalLight> lights, const ExportOptions& options) {
  const std::array<double, 3> total = TotalIrradiance(lights);
  std::string text = fmt::format(
      "{{\n  \"schema\": \"skywave-lights-1\",\n  \"source\": {},\n  \"axes\": [\"right\", "
      "\"forward\", \"up\"],\n  \"total_irradiance\": [{:.17g}, {:.17g}, {:.17g}],\n"
      "  \"total_energy\": {:.17g},\n  \"lights\": [",
      Quoted(options.source), total[0], total[1], total[2], TotalEnergy(lights));
  const char* separator = "\n";
  for (const DirectionalLight& l : lights) {
    text += fmt::format(
        "{}    {{\"direction\": [{:.17g}, {:.17g}, {:.17g}], \"irradiance\": [{:.17g}, {:.17g}, "
        "{:.17g}], \"energy\": {:.17g}, \"solid_angle\": {:.17g}}}",
        separator, l.direction.x, l.direction.y, l.direction.z, l.irradiance[0], l.irradiance[1],
        l.irradiance[2], l.energy, l.solid_angle);
    separator = ",\n";
  }
  return text + "\n  ]\n}\n";
}

std::string Pbrt(std::span<const DirectionalLight> lights, const ExportOptions& options,
                 const WorldAxes& axes) {
  std::string text = Header(lights, options, axes, "#",
                            "L is irradiance on a facing surface; put this right after WorldBegin");
  for (const DirectionalLight& light : lights) {
    const Vector3 d = axes.ToWorld(light.direction);
    text += fmt::format(
        "LightSource \"distant\" \"rgb L\" [ {:.9g} {:.9g} {:.9g} ] "
        "\"point3 from\" [ {:.9g} {:.9g} {:.9g} ] \"point3 to\" [ 0 0 0 ]\n",
        light.irradiance[0], light.irradiance[1], light.irradiance[2], d.x, d.y, d.z);
  }
  if (!options.residual.empty()) {
    // The light space of pbrt's maps has x back, y left, z up. Columns of the matrix are its axes.
    const Vector3 zero, x = zero - axes.forward, y = zero - axes.right, z = axes.up;
    text += fmt::format(
        "# The rest of the map, as an equal-area octahedral square\nAttributeBegin\n"
        "  Transform [ {:g} {:g} {:g} 0 {:g} {:g} {:g} 0 {:g} {:g} {:g} 0 0 0 0 1 ]\n"
        "  LightSource \"infinite\" \"string filename\" {}\nAttributeEnd\n",
        x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z, Quoted(options.residual));
  }
  return text;
}

std::string Povray(std::span<const DirectionalLight> lights, const ExportOptions& options,
                   const WorldAxes& axes) {
  std::string text =
      Header(lights, options, axes, "//", "colour is irradiance / pi; needs assumed_gamma 1");
  text += fmt::format(
      "#ifndef (Skywave_Distance) #declare Skywave_Distance = {:.9g}; #end  // beyond all objects\n"
      "#ifndef (Skywave_Scale) #declare Skywave_Scale = 1; #end\n",
      options.distance);
  for (const DirectionalLight& light : lights) {
    const Vector3 d = axes.ToWorld(light.direction);
    text += fmt::format(
        "light_source {{ <{:.9g}, {:.9g}, {:.9g}> * Skywave_Distance "
        "color rgb <{:.9g}, {:.9g}, {:.9g}> * Skywave_Scale "
        "parallel point_at <0, 0, 0> }}\n",
        d.x, d.y, d.z, light.irradiance[0] / kPi, light.irradiance[1] / kPi,
        light.irradiance[2] / kPi);
  }
  if (!options.residual.empty()) {
    // Spherical images begin at +x and run by way of +z, seen from inside to the left: they are
    // turned over and round, until they lie in the axes x right, y up, z forward.
    const Vector3 &x = axes.right, &y = axes.up, &z = axes.forward;
    text += fmt::format(
        "// The rest of the map; it lights surfaces if global_settings has radiosity\n"
        "sky_sphere {{\n"
        "  pigment {{ image_map {{ {} {} gamma 1 map_type 1 interpolate 2 }} scale <-1, 1, 1> "
        "rotate <0, -90, 0> }}\n"
        "  matrix <{:g}, {:g}, {:g}, {:g}, {:g}, {:g}, {:g}, {:g}, {:g}, 0, 0, 0>\n"
        "  emission rgb Skywave_Scale\n}}\n",
        options.residual.ends_with(".hdr") ? "hdr" : "exr", Quoted(options.residual), x.x, x.y, x.z,
        y.x, y.y, y.z, z.x, z.y, z.z);
  }
  return text;
}

std::string Blender(std::span<const DirectionalLight> lights, const ExportOptions& options,
                    const WorldAxes& axes) {
  std::string text = Header(lights, options, axes, "#", "energy * color is irradiance [W/m^2]");
  text +=
      "# Run it in Blender's text editor, or: blender scene.blend --python THIS\n"
      "import bpy\nfrom mathutils import Vector\n\n"
      "# direction towards the light, energy, color\nLIGHTS = [\n";
  for (const DirectionalLight& light : lights) {
    const Vector3 d = axes.ToWorld(light.direction);
    const Split split = SplitColor(light);
    text += fmt::format("    (({:.9g}, {:.9g}, {:.9g}), {:.9g}, ({:.9g}, {:.9g}, {:.9g})),\n", d.x,
                        d.y, d.z, split.factor, split.color[0], split.color[1], split.color[2]);
  }
  text +=
      "]\n\n"
      "collection = bpy.data.collections.new('skywave lights')\n"
      "bpy.context.scene.collection.children.link(collection)\n"
      "for index, (direction, energy, color) in enumerate(LIGHTS):\n"
      "    light = bpy.data.lights.new('skywave %04d' % index, 'SUN')\n"
      "    light.energy, light.color, light.angle = energy, color, 0\n"
      "    lamp = bpy.data.objects.new(light.name, light)\n"
      "    lamp.location = 10 * Vector(direction)\n"
      "    lamp.rotation_mode = 'QUATERNION'\n"
      "    lamp.rotation_quaternion = Vector(direction).to_track_quat('Z', 'Y')\n"
      "    collection.objects.link(lamp)\n";
  if (!options.residual.empty()) {
    // Blender's world texture has its middle at +x and its right half at -y, z up.
    text += fmt::format(
        "\n# The rest of the map as the world; up must be +z\n"
        "world = bpy.context.scene.world or bpy.data.worlds.new('skywave')\n"
        "bpy.context.scene.world = world\n"
        "world.use_nodes = True\n"
        "nodes, links = world.node_tree.nodes, world.node_tree.links\n"
        "coordinates = nodes.new('ShaderNodeTexCoord')\n"
        "mapping = nodes.new('ShaderNodeMapping')\n"
        "mapping.inputs['Rotation'].default_value = (0, 0, -1.5707963267948966)\n"
        "texture = nodes.new('ShaderNodeTexEnvironment')\n"
        "texture.image = bpy.data.images.load({})\n"
        "links.new(coordinates.outputs['Generated'], mapping.inputs['Vector'])\n"
        "links.new(mapping.outputs['Vector'], texture.inputs['Vector'])\n"
        "background = next(n for n in nodes if n.type == 'BACKGROUND')\n"
        "links.new(texture.outputs['Color'], background.inputs['Color'])\n",
        Quoted(options.residual));
  }
  return text;
}

// Returns the Euler angles in degrees, x then y then z as Maya applies them, that turn -z, along
// which its lights shine, into `shine`. z stays 0.
std::array<double, 3> MayaRotation(const Vector3& shine) {
  const double horizontal = std::hypot(shine.x, shine.z);
  return {std::atan2(shine.y, horizontal) * 180 / kPi,
          horizontal > 0 ? std::atan2(-shine.x, -shine.z) * 180 / kPi : 0, 0};
}

std::string Maya(std::span<const DirectionalLight> lights, const ExportOptions& options,
                 const WorldAxes& axes) {
  std::string text =
      Header(lights, options, axes, "//", "intensity * color is irradiance / pi (lambert shader)");
  text += "string $skywave_light;\nstring $skywave_transform[];\n";
  int index = 0;
  for (const DirectionalLight& light : lights) {
    const Vector3 d = axes.ToWorld(light.direction);
    const Split split = SplitColor(light);
    const std::array<double, 3> turn = MayaRotation(-1.0 * d);
    text += fmt::format(
        "// light {} from {:.9g} {:.9g} {:.9g}\n"
        "$skywave_light = `directionalLight -name \"skywave_{:04}\" -intensity {:.9g} -rgb {:.9g} "
        "{:.9g} {:.9g}`;\n"
        "$skywave_transform = `listRelatives -parent $skywave_light`;\n"
        "setAttr ($skywave_transform[0] + \".rotate\") {:.9g} {:.9g} {:.9g};\n"
        "setAttr ($skywave_light + \".emitSpecular\") 0;\n",
        index, d.x, d.y, d.z, index, split.factor / kPi, split.color[0], split.color[1],
        split.color[2], turn[0], turn[1], turn[2]);
    ++index;
  }
  return text;
}

}  // namespace

WorldAxes AxesOf(LightFormat format, char up_axis) {
  const Vector3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
  if (format == LightFormat::kTable || format == LightFormat::kJson) return {x, y, z};
  if (up_axis == 0) up_axis = format == LightFormat::kBlender ? 'z' : 'y';
  WorldAxes axes = up_axis == 'z'   ? WorldAxes{x, y, z}
                   : up_axis == 'x' ? WorldAxes{Vector3() - z, y, x}
                                    : WorldAxes{x, Vector3() - z, y};
  const bool left_handed = format == LightFormat::kPbrt || format == LightFormat::kPovray;
  if (left_handed) axes.forward = Vector3() - axes.forward;
  return axes;
}

std::string ExportLights(std::span<const DirectionalLight> lights, const ExportOptions& options) {
  const WorldAxes axes = AxesOf(options.format, options.up_axis);
  switch (options.format) {
    case LightFormat::kTable:
      return Table(lights);
    case LightFormat::kJson:
      return Json(lights, options);
    case LightFormat::kPbrt:
      return Pbrt(lights, options, axes);
    case LightFormat::kPovray:
      return Povray(lights, options, axes);
    case LightFormat::kBlender:
      return Blender(lights, options, axes);
    case LightFormat::kMaya:
      return Maya(lights, options, axes);
  }
  return {};
}

}  // namespace skywave
