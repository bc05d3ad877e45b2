// Synthetic illumination maps that challenge builders of lights.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "image/image.h"
#include "lights/vector3.h"

namespace skywave::test {

inline void Fill(Image& image, float r, float g, float b) {
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    image.rgb[i] = r, image.rgb[i + 1] = g, image.rgb[i + 2] = b;
  }
}

inline Image ConstantMap(int width, int height, float value) {
  Image image(width, height);
  Fill(image, value, value, value);
  return image;
}

// Returns a sky that brightens towards the top, a dim ground, a few windows, and a 2 x 2 sun of
// radiance `sun`.
inline Image SunMap(int width, int height, float sun) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float v = float(y) / float(height), u = float(x) / float(width);
      float value = v < 0.5f ? 1.0f - v : 0.15f + 0.05f * std::sin(40 * u);
      if (std::fmod(u * 7, 1.0f) < 0.08f && v > 0.4f && v < 0.47f) value = 12;
      float* rgb = image.Pixel(x, y);
      rgb[0] = value, rgb[1] = value * 0.9f, rgb[2] = value * 1.2f;
    }
  }
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      float* rgb = image.Pixel(width / 3 + x, height / 4 + y);
      rgb[0] = rgb[1] = sun, rgb[2] = sun * 0.8f;
    }
  }
  return image;
}

// Returns log-normal noise: independent texels, over six orders of magnitude.
inline Image NoiseMap(int width, int height, unsigned seed) {
  Image image(width, height);
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  for (float& value : image.rgb) value = std::exp(2.5f * normal(random));
  return image;
}

struct NamedMap {
  std::string name;
  Image image;
};

inline std::vector<NamedMap> AdversarialMaps() {
  std::vector<NamedMap> maps;
  maps.push_back({"one texel", ConstantMap(1, 1, 3)});
  Image small(3, 2);
  for (std::size_t i = 0; i < small.rgb.size(); ++i) small.rgb[i] = float(i * i % 7);
  maps.push_back({"3 x 2", small});
  maps.push_back({"constant", ConstantMap(64, 32, 0.25f)});
  Image ramp(97, 41);  // sides without common factors
  for (std::size_t i = 0; i < ramp.rgb.size(); ++i) ramp.rgb[i] = float(i) * 1e-3f;
  maps.push_back({"ramp", ramp});
  Image seam = ConstantMap(128, 64, 0.01f);
  for (int y = 20; y < 40; ++y) {
    for (int x : {0, 1, 126, 127}) seam.Pixel(x, y)[1] = 50;
  }
  maps.push_back({"seam", seam});
  Image poles = ConstantMap(128, 64, 0.01f);
  for (int x = 0; x < 128; ++x) poles.Pixel(x, 0)[0] = poles.Pixel(x, 63)[2] = 1000;
  maps.push_back({"poles", poles});
  maps.push_back({"sun", SunMap(256, 128, 1e6f)});
  Image single(64, 32);
  single.Pixel(63, 31)[1] = 1e-20f;
  maps.push_back({"one lit texel", single});
  maps.push_back({"noise", NoiseMap(200, 100, 5)});
  maps.push_back({"wide", NoiseMap(301, 7, 6)});
  maps.push_back({"column", NoiseMap(1, 50, 7)});
  maps.push_back({"black", Image(32, 16)});
  return maps;
}

inline Vector3 RandomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  for (;;) {
    const Vector3 v = {normal(random), normal(random), normal(random)};
    if (Length(v) > 1e-3) return (1 / Length(v)) * v;
  }
}

}  // namespace skywave::test
