#include "scene/gltf/names.h"

#include <fmt/format.h>

namespace skywave {

std::string NameOnce(const std::string& name, std::size_t index, std::set<std::string>& taken) {
  std::string unique = name;
  if (name.empty() || taken.contains(name)) unique = fmt::format("{}#{}", name, index);
  while (!taken.insert(unique).second) unique += '\'';
  return unique;
}

}  // namespace skywave
