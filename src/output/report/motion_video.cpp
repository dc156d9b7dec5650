#include "output/report/motion_video.hpp"

#include "base/files/atomic_file.hpp"
#include "base/text/base64.hpp"

namespace conddp {

std::string record_motion(const std::string& page, const BrowserOptions& options,
                          const std::function<void(double)>& on_progress) {
  try {
    Browser browser(options);
    browser.open(page);
    browser.evaluate("void (globalThis.recording = conddp.record(1280, 720))");
    for (;;) {
      // Each call draws and encodes one second of the video.
      const OrderedJson step = browser.evaluate("recording.next()");
      if (!step.at("done").get<bool>()) {
        on_progress(step.at("value").get<double>());
        continue;
      }
      if (auto video = bytes_of_base64(step.at("value").get_ref<const std::string&>()))
        return *std::move(video);
      throw OutputError("the browser's video is no base64");
    }
  } catch (const OrderedJson::exception& error) {
    throw OutputError(std::string("the browser does not speak its protocol: ") + error.what());
  }
}

}  // namespace conddp
