// Sends a picture to the viewer tev while it is rendered, by tev's protocol over TCP
// (docs/references.md, Müller).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace skywave {

// A place where a viewer listens.
struct ViewerAddress {
  std::string host, port;
};
// Reads "HOST", "HOST:PORT" or "[HOST]:PORT"; without a port it is tev's own, 14158. Returns
// nothing for other text.
std::optional<ViewerAddress> ParseViewerAddress(const std::string& text);

// A rectangle of a picture [pixels].
struct DisplayWindow {
  int x, y, width, height;
};

// The packets that a viewer gets. `grab_focus` is false: a new picture does not come to the front.
std::string CreateImagePacket(const std::string& name, int width, int height,
                              const std::vector<std::string>& channels);
// `values` are those of the window, channel by channel and row by row.
std::string UpdateImagePacket(const std::string& name, const DisplayWindow& window,
                              const std::vector<std::string>& channels,
                              const std::vector<float>& values);

// How long a viewer is waited for [s].
struct ViewerPatience {
  double connect = 1;  // until it answers
  double no_read = 2;  // at the end, while it reads nothing
  double at_end = 30;  // at the end, in all
};

// One picture in a viewer. It is a copy of the picture and a list of the blocks in which the copy
// and the viewer differ; a thread of its own sends these. So a slow viewer gets fewer versions of a
// block, always the newest one, the render waits only for the copy, and memory does not grow.
// Nothing throws. A viewer that is missing, leaves or does not read causes one warning.
class TevDisplay {
 public:
  // Begins to connect. `channels` are named as in an EXR file, "R" or "albedo.R".
  TevDisplay(const ViewerAddress& viewer, const std::string& name, int width, int height,
             const std::vector<std::string>& channels, const ViewerPatience& patience = {});
  TevDisplay(const TevDisplay&) = delete;
  TevDisplay& operator=(const TevDisplay&) = delete;
  ~TevDisplay();  // leaves the viewer at once

  // Returns whether anybody may still see an update; if not, there is no need to make one.
  bool watched() const;
  // Takes the values of a window, channel by channel and row by row. Any thread may call this.
  void Update(const DisplayWindow& window, const std::vector<float>& values);
  // Blocks until the viewer has everything or its time is up, then disconnects. Returns what went
  // wrong, or nothing. No updates may follow.
  std::string Finish();

 private:
  struct State;
  std::shared_ptr<State> state_;  // also held by the thread, which may outlive the display
};

}  // namespace skywave
