#include "bench/measure/html.h"

#include <fmt/format.h>

#include <cctype>
#include <cstdint>
#include <cstring>

#include "bench/measure/plot.h"

namespace skywave {
namespace {

std::string Base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t b = 0; b < 3; ++b) {
      group = group << 8 | (i + b < bytes.size() ? static_cast<unsigned char>(bytes[i + b]) : 0);
    }
    for (int d = 3; d >= 0; --d) text += kDigits[group >> 6 * d & 63];
  }
  const std::size_t padding = (3 - bytes.size() % 3) % 3;
  text.replace(text.size() - padding, padding, padding, '=');
  return text;
}

}  // namespace

std::string HtmlStart(std::string_view title, std::string_view style) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n"
      "<title>{}</title>\n<style>{}</style></head>\n<body>\n",
      EscapeXml(title), style);
}

std::string HtmlEnd() { return "</body></html>\n"; }

std::string DataAddress(std::string_view type, std::string_view bytes) {
  return fmt::format("data:{};base64,{}", type, Base64(bytes));
}

std::string FileAddress(std::string_view name) {
  std::string address;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool kept = std::isalnum(byte) != 0 || (c != 0 && std::strchr("-._~/", c) != nullptr);
    address += kept ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return address;
}

}  // namespace skywave
