#include "job/denoise/oidn.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/error.h"

namespace skywave {
namespace {

// What is used of the C interface, version 2: opaque handles and these values.
struct Device;
struct Filter;
constexpr int kDeviceOfProcessor = 1, kNoError = 0, kFloat3 = 3, kHighQuality = 6;

struct Interface {
  Device* (*new_device)(int type);
  void (*commit_device)(Device*);
  void (*release_device)(Device*);
  int (*device_error)(Device*, const char** message);
  int (*device_int)(Device*, const char* name);
  void (*set_device_int)(Device*, const char* name, int value);
  void (*set_device_bool)(Device*, const char* name, bool value);
  Filter* (*new_filter)(Device*, const char* type);
  void (*release_filter)(Filter*);
  void (*set_image)(Filter*, const char* name, void* pixels, int format, std::size_t width,
                    std::size_t height, std::size_t offset, std::size_t pixel_stride,
                    std::size_t row_stride);
  void (*set_filter_bool)(Filter*, const char* name, bool value);
  void (*set_filter_int)(Filter*, const char* name, int value);
  void (*commit_filter)(Filter*);
  void (*execute)(Filter*);
};

constexpr char kLibrary[] = "libOpenImageDenoise.so.2";

// Returns the functions of a library that was opened; nothing if one of them is missing.
std::optional<Interface> FunctionsOf(void* library) {
  Interface oidn = {};
  bool all = true;
  const auto find = [&](const char* name, auto& function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    all = all && function != nullptr;
  };
  find("oidnNewDevice", oidn.new_device);
  find("oidnCommitDevice", oidn.commit_device);
  find("oidnReleaseDevice", oidn.release_device);
  find("oidnGetDeviceError", oidn.device_error);
  find("oidnGetDeviceInt", oidn.device_int);
  find("oidnSetDeviceInt", oidn.set_device_int);
  find("oidnSetDeviceBool", oidn.set_device_bool);
  find("oidnNewFilter", oidn.new_filter);
  find("oidnReleaseFilter", oidn.release_filter);
  find("oidnSetSharedFilterImage", oidn.set_image);
  find("oidnSetFilterBool", oidn.set_filter_bool);
  find("oidnSetFilterInt", oidn.set_filter_int);
  find("oidnCommitFilter", oidn.commit_filter);
  find("oidnExecuteFilter", oidn.execute);
  return all ? std::optional(oidn) : std::nullopt;
}

using DevicePointer = std::unique_ptr<Device, void (*)(Device*)>;

// Returns a device of the processor with as many threads as the current arena; null if it cannot
// be made, as `why` then says.
DevicePointer MakeDevice(const Interface& oidn, std::string& why) {
  DevicePointer device(oidn.new_device(kDeviceOfProcessor), oidn.release_device);
  const char* message = nullptr;
  if (device) {
    oidn.set_device_int(device.get(), "numThreads", tbb::this_task_arena::max_concurrency());
    oidn.set_device_bool(device.get(), "setAffinity", false);
    oidn.commit_device(device.get());
  }
  if (oidn.device_error(device.get(), &message) == kNoError && device) return device;
  why = message != nullptr ? message : "it has no device for this processor";
  return {nullptr, oidn.release_device};
}

std::string Environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Adds the library of the package pyoidn in a folder of packages.
void AddPackage(const std::filesystem::path& packages, std::vector<std::string>& files) {
  files.push_back((packages / "pyoidn/oidn/lib" / kLibrary).string());
}

// Adds those of all Pythons under a folder, as in /usr/local/lib/python3.11/dist-packages.
void AddPythons(const std::filesystem::path& folder, std::vector<std::string>& files) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (!entry.path().filename().string().starts_with("python3")) continue;
    AddPackage(entry.path() / "site-packages", files);
    AddPackage(entry.path() / "dist-packages", files);
  }
}

// Returns the files that may be the library, the first choice first.
std::vector<std::string> Candidates() {
  std::vector<std::string> files;
  if (const std::string named = Environment("SKYWAVE_OIDN"); !named.empty()) {
    std::error_code error;
    if (!std::filesystem::is_directory(named, error)) return {named};
    return {(std::filesystem::path(named) / kLibrary).string(),
            (std::filesystem::path(named) / "lib" / kLibrary).string()};
  }
  files.emplace_back(kLibrary);
  // A wheel's own libraries lie beside or in its package, in a folder of packages.
  Dl_info here = {};
  if (dladdr(reinterpret_cast<const void*>(&OidnVersion), &here) != 0 &&
      here.dli_fname != nullptr) {
    std::error_code error;
    auto folder = std::filesystem::absolute(here.dli_fname, error).parent_path();
    for (int up = 0; up < 3 && folder.has_relative_path(); ++up) {
      if (std::filesystem::exists(folder / "pyoidn", error)) AddPackage(folder, files);
      folder = folder.parent_path();
    }
  }
  for (const auto& [variable, below] : {std::pair("VIRTUAL_ENV", "lib"), {"HOME", ".local/lib"}}) {
    const std::string root = Environment(variable);
    if (!root.empty()) AddPythons(std::filesystem::path(root) / below, files);
  }
  AddPythons("/usr/local/lib", files);
  AddPythons("/usr/lib", files);
  return files;
}

// The library, once it was looked for; it stays open.
struct Library {
  std::optional<Interface> oidn;
  std::string version;  // empty: there is none
  std::string tried;    // what was found instead, a line each
};

Library Open() {
  Library library;
  for (const std::string& file : Candidates()) {
    std::string why;
    if (void* const opened = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      library.oidn = FunctionsOf(opened);
      if (library.oidn) {
        if (const DevicePointer device = MakeDevice(*library.oidn, why)) {
          const int version = library.oidn->device_int(device.get(), "version");
          library.version =
              fmt::format("{}.{}.{}", version / 10000, version / 100 % 100, version % 100);
          return library;
        }
      } else {
        why = "is no Open Image Denoise of version 2";
      }
      dlclose(opened);
    } else {
      const char* const message = dlerror();
      why = message != nullptr ? message : "cannot be opened";
    }
    library.tried += fmt::format("\n  {}: {}", file, why);
  }
  library.oidn.reset();
  return library;
}

const Library& OpenedLibrary() {
  static const Library library = Open();
  return library;
}

}  // namespace

std::string OidnVersion() { return OpenedLibrary().version; }

OidnError::OidnError(const std::string& why)
    : InputError(InputPosition::File("Open Image Denoise " + OidnVersion()), why) {}

void RequireOidn() {
  if (OpenedLibrary().oidn) return;
  throw OptionError(
      "denoise", "oidn",
      fmt::format("Open Image Denoise is not there: install it (pip install pyoidn), or "
                  "name its file or folder in SKYWAVE_OIDN; tried{}",
                  OpenedLibrary().tried));
}

std::vector<float> DenoiseByOidn(const OidnPicture& picture) {
  RequireOidn();
  const Interface& oidn = *OpenedLibrary().oidn;
  std::string why;
  const DevicePointer device = MakeDevice(oidn, why);
  const auto check = [&] {
    const char* message = nullptr;
    if (device && oidn.device_error(device.get(), &message) == kNoError) return;
    if (message != nullptr) why = message;
    throw OidnError(why);
  };
  check();
  std::vector<float> clean(picture.color.size());
  const std::unique_ptr<Filter, void (*)(Filter*)> filter(oidn.new_filter(device.get(), "RT"),
                                                          oidn.release_filter);
  const auto set = [&](const char* name, const std::vector<float>& pixels) {
    oidn.set_image(filter.get(), name, const_cast<float*>(pixels.data()), kFloat3,
                   std::size_t(picture.width), std::size_t(picture.height), 0, 0, 0);
  };
  set("color", picture.color), set("albedo", picture.albedo), set("normal", picture.normal);
  set("output", clean);
  oidn.set_filter_bool(filter.get(), "hdr", true);
  oidn.set_filter_bool(filter.get(), "cleanAux", true);
  oidn.set_filter_int(filter.get(), "quality", kHighQuality);
  oidn.commit_filter(filter.get());
  oidn.execute(filter.get());
  check();
  return clean;
}

}  // namespace skywave
