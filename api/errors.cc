#include "api/errors.h"

#include <exception>
#include <new>

#include "base/error.h"
#include "wavefront/worker_pool.h"

namespace skywave::api {
namespace {

Error::Kind KindOf(const InputError& error) {
  switch (error.exit_code()) {
    case kExitUsage:
      return Error::Kind::kUsage;
    case kExitIo:
      return Error::Kind::kIo;
    default:
      return Error::Kind::kBadInput;
  }
}

std::string NamesOf(const OptionError& error) {
  std::string names;
  for (const skywave::OptionValue& option : error.options()) {
    if (!names.empty()) names += ' ';
    names += option.name;
    if (!option.value.empty()) names += ' ' + option.value;
  }
  return names;
}

}  // namespace

Error::Error(Kind kind, const std::string& place, const std::string& reason)
    : std::runtime_error(place.empty() ? reason : place + ": " + reason),
      kind_(kind),
      place_(place) {}

Canceled::Canceled() : std::runtime_error("the render was canceled") {}

void Require(bool condition, const std::string& place, const std::string& reason) {
  if (!condition) throw Error(Error::Kind::kUsage, place, reason);
}

void RethrowTranslated() {
  try {
    throw;
  } catch (const OptionError& error) {
    std::throw_with_nested(Error(KindOf(error), NamesOf(error), error.why()));
  } catch (const InputError& error) {
    std::throw_with_nested(Error(KindOf(error), error.place(), error.reason()));
  } catch (const RenderCanceled&) {
    throw Canceled();
  } catch (const std::bad_alloc&) {
    std::throw_with_nested(Error(Error::Kind::kIo, "", "out of memory"));
  }
}

}  // namespace skywave::api
