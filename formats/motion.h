#pragma once

#include <array>
#include <cstddef>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace phiz {

/// Frames that were not recorded.
struct MotionGap {
  std::size_t after_frame = 0;  ///< the last frame before it
  int missing_frames = 0;
};

/// Named curves over time: names as their file has them ("JawOpen", "jawOpen", "HeadYaw").
struct Motion {
  std::vector<std::string> names;  ///< each once; at least one
  double frames_per_second = 60;   ///< in (0, 1000]
  std::vector<double> times_s;     ///< from 0, strictly ascending; one a frame, at least one
  std::vector<float> values;       ///< [frame * names.size() + name]; finite; angles in radians
  std::vector<MotionGap> gaps;     ///< where times_s leaves out frames of the rate

  std::size_t frame_count() const { return times_s.size(); }
  std::span<const float> frame(std::size_t i) const {
    return {values.data() + i * names.size(), names.size()};
  }
};

/// Throws FormatError where sizes do not belong together, names repeat or are empty, numbers are not finite,
/// times do not ascend.
void check_motion(const Motion& motion);

/// Takes any of the three, told apart by their first characters (README.md has the grammar): a Live Link Face
/// CSV (`Timecode,BlendShapeCount,...`, columns by name, in any order; the rate is derived from the
/// timecode), a plain CSV (first column `time_s`, or `frame` with the rate in a line `# fps N`), a JSON.
/// Throws FormatError with line and column: missing or repeated columns, rows of another length, what is no
/// finite number, times that go back.
Motion read_motion(std::istream& in);

/// Same motion, same bytes; reading gives the same motion back (times and values are exact).
void write_motion_csv(const Motion& motion, std::ostream& out);
void write_motion_json(const Motion& motion, std::ostream& out);
/// All 63 columns in Live Link Face's order; ARKit names are matched without regard to the first letter's
/// case, what the motion lacks is 0, what the file has no column for is left out. Timecodes have steps of
/// 1/1000 frame.
void write_live_link_csv(const Motion& motion, std::ostream& out);

/// Every 1 / frames_per_second from the first to the last frame, linear between frames (across gaps too; the
/// gaps stay named). A motion that already has the rate and no gap is returned as it is. Throws FormatError
/// for rates beyond (0, 1000] and more than 10 million frames.
Motion resample_motion(const Motion& motion, double frames_per_second);

/// Finds the rate (median step) and the gaps (steps of more than one and a half) from times_s.
void find_rate_and_gaps(Motion& motion);

std::span<const std::string_view> arkit_names();       ///< the 52, in camelCase, in ARKit's order
std::span<const std::string_view> live_link_angles();  ///< HeadYaw ... RightEyeRoll, radians
/// ARKit's name for "JawOpen", "jawOpen", "mouthSmile_L" and the like; empty if it is none of the 52.
std::string find_arkit_name(const std::string& name);

}  // namespace phiz
