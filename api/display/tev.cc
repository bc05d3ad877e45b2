#include "api/display/tev.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <cerrno>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include "base/clock.h"

namespace skywave {
namespace {

static_assert(std::endian::native == std::endian::little, "the protocol's numbers are");

constexpr char kCreateImage = 4, kUpdateImageV3 = 6;
constexpr int kBlockSide = 64;
// Seconds between two rounds of updates. Otherwise a block of small tiles would be sent once per
// tile.
constexpr double kPause = 0.2;

// Appends the fields of a packet. The first four bytes are its length, which counts them too.
class Packet {
 public:
  explicit Packet(char operation) : bytes_(4, '\0') { bytes_ += operation; }
  template <class Number>
  Packet& Put(Number value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Packet& PutText(const std::string& text) {
    bytes_.append(text.c_str(), text.size() + 1);
    return *this;
  }
  Packet& PutTexts(const std::vector<std::string>& texts) {
    Put(std::int32_t(texts.size()));
    for (const std::string& text : texts) PutText(text);
    return *this;
  }
  Packet& PutFloats(const std::vector<float>& values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    return *this;
  }
  std::string Take() {
    const auto length = std::uint32_t(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof length);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

// A connection, closed at the end; -1: none.
class Socket {
 public:
  explicit Socket(int descriptor = -1) : descriptor_(descriptor) {}
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Socket() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

// Waits until the socket can be written to. Returns whether it can.
bool WaitForRoom(const Socket& socket, double seconds) {
  pollfd wait = {.fd = socket.get(), .events = POLLOUT, .revents = 0};
  return poll(&wait, 1, int(seconds * 1000)) > 0;
}

// Returns a connection that does not block, or none and why.
Socket Connect(const ViewerAddress& viewer, double seconds, std::string& why) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(viewer.host.c_str(), viewer.port.c_str(), &hints, &found)) {
    why = gai_strerror(error);
    return Socket();
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, freeaddrinfo);
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    Socket socket(::socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (socket.get() < 0) continue;
    int error = 0;
    if (connect(socket.get(), address->ai_addr, address->ai_addrlen) != 0) {
      error = errno;
      if (error == EINPROGRESS) {
        socklen_t size = sizeof error;
        error = ETIMEDOUT;
        if (WaitForRoom(socket, seconds)) {
          getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &size);
        }
      }
    }
    if (error == 0) return socket;
    why = std::strerror(error);
  }
  return Socket();
}

}  // namespace

std::optional<ViewerAddress> ParseViewerAddress(const std::string& text) {
  constexpr char kOwnPort[] = "14158";
  std::string host = text, port = kOwnPort;
  const bool bracket = text.starts_with('[');
  const std::size_t end = bracket ? text.find(']') : text.find(':');
  if (bracket && end == std::string::npos) return std::nullopt;
  if (end != std::string::npos) {
    host = bracket ? text.substr(1, end - 1) : text.substr(0, end);
    const std::string rest = text.substr(bracket ? end + 1 : end);
    if (!rest.empty()) {
      if (rest[0] != ':') return std::nullopt;
      port = rest.substr(1);
    }
  }
  const bool digits =
      std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (host.empty() || port.empty() || port.size() > 5 || !digits) return std::nullopt;
  const int number = std::stoi(port);
  if (number < 1 || number > 65535) return std::nullopt;
  return ViewerAddress{host, port};
}

std::string CreateImagePacket(const std::string& name, int width, int height,
                              const std::vector<std::string>& channels) {
  return Packet(kCreateImage)
      .Put(char{0})
      .PutText(name)
      .Put(std::int32_t(width))
      .Put(std::int32_t(height))
      .PutTexts(channels)
      .Take();
}

std::string UpdateImagePacket(const std::string& name, const DisplayWindow& window,
                              const std::vector<std::string>& channels,
                              const std::vector<float>& values) {
  const auto pixels = std::int64_t(window.width) * window.height;
  assert(values.size() == std::size_t(pixels) * channels.size());
  Packet packet(kUpdateImageV3);
  packet.Put(char{0}).PutText(name).PutTexts(channels);
  for (const int side : {window.x, window.y, window.width, window.height}) {
    packet.Put(std::int32_t(side));
  }
  // Offsets and strides of the channels, in floats.
  for (std::size_t c = 0; c < channels.size(); ++c) packet.Put(std::int64_t(c) * pixels);
  for (std::size_t c = 0; c < channels.size(); ++c) packet.Put(std::int64_t{1});
  return packet.PutFloats(values).Take();
}

struct TevDisplay::State {
  // Constant.
  ViewerAddress viewer;
  std::string name;
  int width, height;
  std::vector<std::string> channels;
  ViewerPatience patience;
  int blocks_across;

  std::atomic<bool> watched = true;
  std::mutex mutex;  // of all that follows
  std::condition_variable changed;
  std::vector<float> values;       // of the picture, channel by channel
  std::vector<bool> waits;         // by block: the viewer does not have its newest values
  std::vector<std::size_t> order;  // those of the next round, the oldest first
  bool finishing = false, leave = false, ended = false;
  Clock::time_point finish_start;
  std::string warning;

  DisplayWindow BlockWindow(std::size_t block) const {
    const int x = int(block % std::size_t(blocks_across)) * kBlockSide;
    const int y = int(block / std::size_t(blocks_across)) * kBlockSide;
    return {x, y, std::min(kBlockSide, width - x), std::min(kBlockSide, height - y)};
  }
  // Waits for blocks to send and returns them; none: the end.
  std::vector<std::size_t> NextRound() {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::duration<double>(kPause),
                     [&] { return leave || finishing; });
    changed.wait(lock, [&] { return leave || finishing || !order.empty(); });
    return leave ? std::vector<std::size_t>() : std::exchange(order, {});
  }
  // Returns the newest values of a block.
  std::vector<float> Take(std::size_t block) {
    const DisplayWindow window = BlockWindow(block);
    std::vector<float> copy;
    const std::lock_guard lock(mutex);
    waits[block] = false;
    copy.reserve(channels.size() * std::size_t(window.width) * std::size_t(window.height));
    ForEachRow(window, [&](std::size_t first) {
      copy.insert(copy.end(), values.begin() + std::ptrdiff_t(first),
                  values.begin() + std::ptrdiff_t(first) + window.width);
    });
    return copy;
  }
  // Calls `row` with the index of the first value of each row of a window, channel by channel.
  template <class Row>
  void ForEachRow(const DisplayWindow& window, const Row& row) const {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (int y = window.y; y < window.y + window.height; ++y) {
        row((c * std::size_t(height) + std::size_t(y)) * std::size_t(width) +
            std::size_t(window.x));
      }
    }
  }
  // Returns whether to wait for the viewer any longer. `idle`: the time since it last read
  // something.
  bool MayWait(const Clock::time_point& idle) {
    const std::lock_guard lock(mutex);
    if (leave) return false;
    if (!finishing) return true;
    const double since = std::min(SecondsSince(idle), SecondsSince(finish_start));
    return since < patience.no_read && SecondsSince(finish_start) < patience.at_end;
  }
  // Returns what went wrong, or nothing.
  std::string Send(const Socket& socket, const std::string& packet) {
    Clock::time_point idle = Clock::now();
    for (std::size_t sent = 0; sent < packet.size();) {
      const ssize_t count =
          send(socket.get(), packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
      if (count > 0) {
        sent += std::size_t(count);
        idle = Clock::now();
      } else if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
        return fmt::format("has left ({})", std::strerror(errno));
      } else if (!MayWait(idle)) {
        return "does not read";
      } else {
        WaitForRoom(socket, 0.05);
      }
    }
    return "";
  }
  std::string SendAll() {
    std::string why = "does not answer";
    const Socket socket = Connect(viewer, patience.connect, why);
    if (socket.get() < 0) return fmt::format("cannot be reached ({})", why);
    const int on = 1;
    setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    std::string problem = Send(socket, CreateImagePacket(name, width, height, channels));
    while (problem.empty()) {
      const std::vector<std::size_t> blocks = NextRound();
      if (blocks.empty()) break;
      for (const std::size_t block : blocks) {
        problem = Send(socket, UpdateImagePacket(name, BlockWindow(block), channels, Take(block)));
        if (!problem.empty()) break;
      }
    }
    return problem;
  }
  void Run() {
    const std::string problem = SendAll();
    watched = false;
    const std::lock_guard lock(mutex);
    if (!problem.empty()) {
      warning = fmt::format("the viewer at {}:{} {}", viewer.host, viewer.port, problem);
    }
    ended = true;
    changed.notify_all();
  }
};

TevDisplay::TevDisplay(const ViewerAddress& viewer, const std::string& name, int width, int height,
                       const std::vector<std::string>& channels, const ViewerPatience& patience)
    : state_(std::make_shared<State>()) {
  State& state = *state_;
  state.viewer = viewer;
  state.name = name;
  state.width = width;
  state.height = height;
  state.channels = channels;
  state.patience = patience;
  state.blocks_across = (width + kBlockSide - 1) / kBlockSide;
  const int blocks_down = (height + kBlockSide - 1) / kBlockSide;
  state.values.resize(channels.size() * std::size_t(width) * std::size_t(height));
  state.waits.resize(std::size_t(state.blocks_across) * std::size_t(blocks_down));
  // It is detached because a look-up of a host name cannot be interrupted.
  std::thread([shared = state_] { shared->Run(); }).detach();
}

TevDisplay::~TevDisplay() {
  const std::lock_guard lock(state_->mutex);
  state_->leave = true;
  state_->changed.notify_all();
}

bool TevDisplay::watched() const { return state_->watched; }

void TevDisplay::Update(const DisplayWindow& window, const std::vector<float>& values) {
  State& state = *state_;
  if (!state.watched || window.width <= 0 || window.height <= 0) return;
  assert(values.size() ==
         state.channels.size() * std::size_t(window.width) * std::size_t(window.height));
  const std::lock_guard lock(state.mutex);
  auto from = values.begin();
  state.ForEachRow(window, [&](std::size_t first) {
    std::copy(from, from + window.width, state.values.begin() + std::ptrdiff_t(first));
    from += window.width;
  });
  for (int y = window.y / kBlockSide; y <= (window.y + window.height - 1) / kBlockSide; ++y) {
    for (int x = window.x / kBlockSide; x <= (window.x + window.width - 1) / kBlockSide; ++x) {
      const std::size_t block = std::size_t(y) * std::size_t(state.blocks_across) + std::size_t(x);
      if (state.waits[block]) continue;
      state.waits[block] = true;
      state.order.push_back(block);
    }
  }
  state.changed.notify_all();
}

std::string TevDisplay::Finish() {
  State& state = *state_;
  std::unique_lock lock(state.mutex);
  state.finishing = true;
  state.finish_start = Clock::now();
  state.changed.notify_all();
  const double longest = state.patience.connect + state.patience.at_end;
  if (!state.changed.wait_for(lock, std::chrono::duration<double>(longest),
                              [&] { return state.ended; })) {
    return fmt::format("the viewer at {}:{} does not answer", state.viewer.host, state.viewer.port);
  }
  return state.warning;
}

}  // namespace skywave
