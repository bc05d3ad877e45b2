#include "job/links.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/nearest_name.h"
#include "job/marks.h"
#include "wavefront/film/light_groups.h"
#include "wavefront/policies/control_pilot.h"

namespace skywave {
namespace {

constexpr char kEnvironment[] = "environment";

struct Link {
  std::string option, light;
  bool of_shadows = false;
  bool excludes = false;           // the light is linked to all but these
  std::vector<std::string> names;  // of materials and meshes
};

Link ParseLink(const std::string& option, const std::string& text) {
  const auto refuse = [&] {
    throw OptionError(option, text,
                      "is not LIGHT:NAME,NAME..., nor LIGHT:!NAME,NAME... for all but");
  };
  const std::size_t colon = text.find(':');
  if (colon == 0 || colon == std::string::npos) refuse();
  Link link = {.option = option, .light = text.substr(0, colon), .names = {}};
  std::string_view rest = std::string_view(text).substr(colon + 1);
  link.excludes = rest.starts_with('!');
  if (link.excludes) rest.remove_prefix(1);
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    more = comma != std::string_view::npos;
    link.names.emplace_back(rest.substr(0, comma));
    if (link.names.back().empty()) refuse();
    if (more) rest.remove_prefix(comma + 1);
  }
  return link;
}

// Returns all links of a request, in the order of their bits.
std::vector<Link> LinksOf(const JobRequest& request) {
  std::vector<Link> links;
  for (const std::string& text : request.links) links.push_back(ParseLink("link", text));
  for (const std::string& text : request.shadow_links) {
    links.push_back(ParseLink("shadow-link", text));
    links.back().of_shadows = true;
  }
  std::set<std::pair<std::string, std::string>> known;
  for (const Link& link : links) {
    if (!known.emplace(link.option, link.light).second) {
      throw OptionError(link.option, link.light, "has two of these links: name all in one");
    }
  }
  if (links.size() > kMostLinks) {
    throw OptionError(
        links.back().option, links.back().light,
        fmt::format("there are {} links, and a scene can have {}", links.size(), kMostLinks));
  }
  return links;
}

}  // namespace

void MarkLinks(const JobRequest& request, Scene& scene) {
  const std::vector<Link> links = LinksOf(request);
  for (std::size_t i = 0; i < links.size(); ++i) {
    const std::uint32_t bit = 1u << i;
    std::uint32_t Material::*const bits =
        links[i].of_shadows ? &Material::unshadowed : &Material::unlit;
    Mark(links[i].option, links[i].names, BitOf(bits, bit), scene);
    if (links[i].excludes) continue;
    for (Material& material : scene.materials) material.*bits ^= bit;
  }
}

void PlanLinks(JobRequest& request, bool has_catchers) {
  const std::size_t count = request.links.size() + request.shadow_links.size();
  if (count == 0) return;
  request.options.of<LinkOptions>().count = std::uint32_t(count);
  const std::string option = request.links.empty() ? "shadow-link" : "link";
  if (request.options.of<ControlOptions>().control != ControlVariate::kNone) {
    throw OptionError(option, "", "what `control` knows is light for all surfaces");
  }
  if (has_catchers && !request.shadow_links.empty()) {
    throw OptionError("shadow-link", "", "catchers are followed with and without all objects");
  }
}

LightLinks MakeLinks(const JobRequest& request, const Scene& scene, const Geometry& geometry,
                     const LocalLightView& lights, bool has_environment) {
  const std::vector<Link> links = LinksOf(request);
  LightLinks made;
  if (links.empty()) return made;
  std::vector<std::string> names;
  std::set<std::string_view> known;
  for (std::uint32_t i = 0; i < lights.count; ++i) {
    names.push_back(NameOfLight(lights.lights[i], scene, geometry));
  }
  known.insert(names.begin(), names.end());
  if (has_environment) known.insert(kEnvironment);
  for (const Material& material : scene.materials) made.unlit.push_back(material.unlit);
  made.of_light.resize(lights.count);
  made.stops_of_link.resize(kMostLinks);
  made.stops.reserve(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const std::uint32_t bit = 1u << i;
    if (!known.contains(link.light)) {
      throw OptionError(link.option, link.light,
                        fmt::format("no light has this name; there are {}",
                                    NearestFirst(link.light, {known.begin(), known.end()})));
    }
    if (has_environment && link.light == kEnvironment) made.view.of_environment |= bit;
    for (std::size_t light = 0; light < names.size(); ++light) {
      if (names[light] == link.light) made.of_light[light] |= bit;
    }
    if (!link.of_shadows) continue;
    made.view.of_shadows |= bit;
    std::vector<std::uint8_t>& stops = made.stops.emplace_back();
    for (const Material& material : scene.materials) {
      stops.push_back((material.unshadowed & bit) == 0);
    }
    // Null: all do, so rays need no filter.
    const bool all = std::find(stops.begin(), stops.end(), 0) == stops.end();
    made.stops_of_link[i] = all ? nullptr : stops.data();
  }
  made.view.unlit = made.unlit.data();
  made.view.of_light = made.of_light.data();
  made.view.stops = made.stops_of_link.data();
  return made;
}

}  // namespace skywave
