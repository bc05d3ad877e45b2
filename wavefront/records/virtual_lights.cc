#include "wavefront/records/virtual_lights.h"

#include <algorithm>
#include <bit>
#include <type_traits>

namespace skywave {

void RepeatVirtualLight(const VirtualLight& light, std::uint32_t n, const SurfaceColumns& rows) {
  const std::uint32_t* word = light.words.data();
  SurfaceColumns::ForEachColumn(rows, [&](auto* column) {
    using Value = std::remove_reference_t<decltype(*column)>;
    std::fill_n(column, PaddedRows(n) - kPadRows, std::bit_cast<Value>(*word++));
  });
}

}  // namespace skywave
