// Stands in for Open Image Denoise: a library with its C interface whose network is a mean over
// 5 x 5 pixels. Like the real one it says what is wrong by the device. With OIDN_STAND_IN=fails its
// filter fails, and with OIDN_STAND_IN=lame it has no device.
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

namespace {

bool Is(const char* what) {
  const char* const wanted = std::getenv("OIDN_STAND_IN");
  return wanted != nullptr && std::strcmp(wanted, what) == 0;
}

struct Picture {
  float* pixels;
  int format;
  int width, height;
};

const char* error_without_device = nullptr;

}  // namespace

struct Device {
  const char* error = nullptr;
  int threads = 0;
  bool affinity = true, committed = false;
};
struct Filter {
  Device* device;
  std::map<std::string, Picture> pictures;
  std::map<std::string, bool> switches;
  int quality = 0;
  bool committed = false;
};

extern "C" {

Device* oidnNewDevice(int type) {
  if (Is("lame") || type != 1) {
    error_without_device = "the stand-in is lame";
    return nullptr;
  }
  return new Device;
}
void oidnCommitDevice(Device* device) { device->committed = true; }
void oidnReleaseDevice(Device* device) { delete device; }
int oidnGetDeviceError(Device* device, const char** message) {
  const char*& error = device != nullptr ? device->error : error_without_device;
  const char* const now = error;
  error = nullptr;
  if (now == nullptr) return 0;
  *message = now;
  return 1;
}
int oidnGetDeviceInt(Device*, const char* name) {
  return std::strcmp(name, "version") == 0 ? 29803 : 0;
}
void oidnSetDeviceInt(Device* device, const char* name, int value) {
  if (std::strcmp(name, "numThreads") == 0) device->threads = value;
}
void oidnSetDeviceBool(Device* device, const char* name, bool value) {
  if (std::strcmp(name, "setAffinity") == 0) device->affinity = value;
}

Filter* oidnNewFilter(Device* device, const char* type) {
  if (!device->committed || std::strcmp(type, "RT") != 0) device->error = "no such filter";
  return new Filter{device, {}, {}};
}
void oidnReleaseFilter(Filter* filter) { delete filter; }
void oidnSetSharedFilterImage(Filter* filter, const char* name, void* pixels, int format,
                              std::size_t width, std::size_t height, std::size_t, std::size_t,
                              std::size_t) {
  filter->pictures[name] = {static_cast<float*>(pixels), format, int(width), int(height)};
}
void oidnSetFilterBool(Filter* filter, const char* name, bool value) {
  filter->switches[name] = value;
}
void oidnSetFilterInt(Filter* filter, const char* name, int value) {
  if (std::strcmp(name, "quality") == 0) filter->quality = value;
}
void oidnCommitFilter(Filter* filter) { filter->committed = true; }
void oidnExecuteFilter(Filter* filter) {
  Device& device = *filter->device;
  const bool is_ready = filter->committed && filter->pictures.size() == 4 &&
                        filter->switches["hdr"] && filter->switches["cleanAux"] &&
                        filter->quality == 6 && device.threads > 0 && !device.affinity;
  if (Is("fails") || !is_ready) {
    device.error = is_ready ? "the stand-in fails" : "the stand-in was not told what it needs";
    return;
  }
  const Picture &color = filter->pictures["color"], &output = filter->pictures["output"];
  for (int y = 0; y < color.height; ++y) {
    for (int x = 0; x < color.width; ++x) {
      float sum[3] = {};
      for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
          const int column = std::clamp(x + dx, 0, color.width - 1);
          const int row = std::clamp(y + dy, 0, color.height - 1);
          for (int c = 0; c < 3; ++c) sum[c] += color.pixels[3 * (row * color.width + column) + c];
        }
      }
      for (int c = 0; c < 3; ++c) output.pixels[3 * (y * color.width + x) + c] = sum[c] / 25;
    }
  }
}

}  // extern "C"
