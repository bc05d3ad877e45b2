// A viewer as tev is one, for the tests: it listens on a free port of this machine and decodes what
// it gets into pictures. It is written from the protocol, not from our client.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace skywave {

// A picture in the viewer: a plane of values for each channel.
struct ViewedPicture {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> channels;
  int updates = 0;
  int replaced = 0;  // values that were shown, not 0, and became others
};

class Viewer {
 public:
  // What it does with a connection.
  enum class Habit {
    kReads,
    kIgnores,  // takes the connection and reads nothing, with as small a buffer as there is
    kLeaves    // closes it after the first packet
  };

  explicit Viewer(Habit habit = Habit::kReads) : habit_(habit), listener_(Listen()) {
    if (habit_ == Habit::kIgnores) {
      const int size = 1;
      setsockopt(listener_, SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
    }
    if (listen(listener_, 1) != 0) throw std::runtime_error("listen");
    sockaddr_in address = {};
    socklen_t size = sizeof address;
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Serve(); });
  }
  ~Viewer() { Stop(); }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  int port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  // Waits until the client has left, where this viewer reads. Returns the pictures by name, or
  // throws what was wrong with a packet.
  std::map<std::string, ViewedPicture> Close() {
    Stop();
    if (!problem_.empty()) throw std::runtime_error(problem_);
    return pictures_;
  }

 private:
  // Reads the fields of a packet in their order.
  class Fields {
   public:
    explicit Fields(const std::string& bytes) : next_(bytes.data()), end_(next_ + bytes.size()) {}
    template <class Number>
    Number Get() {
      Require(std::size_t(end_ - next_) >= sizeof(Number));
      Number value;
      std::memcpy(&value, next_, sizeof value);
      next_ += sizeof value;
      return value;
    }
    std::string Text() {
      const void* const zero = std::memchr(next_, 0, std::size_t(end_ - next_));
      Require(zero != nullptr);
      const std::string text(next_);
      next_ += text.size() + 1;
      return text;
    }
    std::vector<std::string> Texts() {
      std::vector<std::string> texts(std::size_t(Get<std::int32_t>()));
      for (std::string& text : texts) text = Text();
      return texts;
    }
    std::size_t left() const { return std::size_t(end_ - next_); }
    static void Require(bool condition) {
      if (!condition) throw std::runtime_error("a packet that is no packet of tev");
    }

   private:
    const char *next_, *end_;
  };

  void Stop() {
    if (!thread_.joinable()) return;
    if (habit_ != Habit::kReads) shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
    if (connection_ >= 0) close(connection_);
  }
  static int Listen() {
    const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (bind(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error("bind");
    }
    return descriptor;
  }

  void Serve() {
    connection_ = accept(listener_, nullptr, nullptr);
    if (connection_ < 0 || habit_ == Habit::kIgnores) return;
    try {
      for (std::string packet; Receive(packet);) {
        Decode(packet);
        if (habit_ == Habit::kLeaves) {
          close(connection_);
          connection_ = -1;
          return;
        }
      }
    } catch (const std::exception& error) {
      problem_ = error.what();
    }
  }

  bool ReceiveBytes(char* bytes, std::size_t count) {
    while (count > 0) {
      const ssize_t got = recv(connection_, bytes, count, 0);
      if (got <= 0) return false;
      bytes += got;
      count -= std::size_t(got);
    }
    return true;
  }
  // Takes what follows the length, which counts itself too.
  bool Receive(std::string& packet) {
    std::uint32_t length;
    if (!ReceiveBytes(reinterpret_cast<char*>(&length), sizeof length)) return false;
    Fields::Require(length > sizeof length && length < 1u << 28);
    packet.resize(length - sizeof length);
    Fields::Require(ReceiveBytes(packet.data(), packet.size()));
    return true;
  }

  void Decode(const std::string& packet) {
    Fields fields(packet);
    const int operation = fields.Get<std::uint8_t>();
    Fields::Require(fields.Get<std::uint8_t>() <= 1);  // whether to come to the front
    ViewedPicture& picture = pictures_[fields.Text()];
    if (operation == 4) {
      picture.width = fields.Get<std::int32_t>();
      picture.height = fields.Get<std::int32_t>();
      Fields::Require(picture.width > 0 && picture.height > 0);
      for (const std::string& name : fields.Texts()) {
        picture.channels[name].assign(std::size_t(picture.width) * std::size_t(picture.height), 0);
      }
      Fields::Require(fields.left() == 0);
      return;
    }
    Fields::Require(operation == 6 && picture.width > 0);
    ++picture.updates;
    const std::vector<std::string> names = fields.Texts();
    const int x = fields.Get<std::int32_t>(), y = fields.Get<std::int32_t>();
    const int width = fields.Get<std::int32_t>(), height = fields.Get<std::int32_t>();
    Fields::Require(x >= 0 && y >= 0 && width > 0 && height > 0 && x + width <= picture.width &&
                    y + height <= picture.height);
    std::vector<std::int64_t> offsets(names.size()), strides(names.size());
    for (std::int64_t& offset : offsets) offset = fields.Get<std::int64_t>();
    for (std::int64_t& stride : strides) stride = fields.Get<std::int64_t>();
    std::vector<float> values(fields.left() / sizeof(float));
    for (float& value : values) value = fields.Get<float>();
    Fields::Require(fields.left() == 0);
    std::int64_t needed = 0;
    for (std::size_t c = 0; c < names.size(); ++c) {
      Fields::Require(picture.channels.contains(names[c]));
      std::vector<float>& plane = picture.channels[names[c]];
      for (int i = 0; i < width * height; ++i) {
        const std::int64_t index = offsets[c] + i * strides[c];
        Fields::Require(index >= 0 && index < std::int64_t(values.size()));
        needed = std::max(needed, index + 1);
        float& shown = plane[std::size_t(y + i / width) * std::size_t(picture.width) +
                             std::size_t(x + i % width)];
        const float value = values[std::size_t(index)];
        const bool same =
            std::bit_cast<std::uint32_t>(shown) == std::bit_cast<std::uint32_t>(value);
        if (shown != 0 && !same) ++picture.replaced;
        shown = value;
      }
    }
    Fields::Require(needed == std::int64_t(values.size()));
  }

  Habit habit_;
  int listener_, connection_ = -1, port_ = 0;
  std::map<std::string, ViewedPicture> pictures_;
  std::string problem_;
  std::thread thread_;
};

}  // namespace skywave
