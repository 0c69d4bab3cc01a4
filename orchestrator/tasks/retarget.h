#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "formats/head_asset.h"
#include "stages/retarget/retarget.h"

namespace phiz {

enum class RetargetFormat { kNone, kGlb, kObj };

/// What all subjects of one run share. Made once; const calls from several threads are safe.
class RetargetPlan {
 public:
  RetargetPlan(Deformation rig, const ControlMesh& generic_head, ParameterTrack track, int level);

  struct Outcome {
    MotionFigures figures;
    double morph_error_mm = 0;  ///< of a .glb: how far its morph targets are from the cascade at most
    std::size_t bytes = 0;      ///< written
  };
  /// Hands every file it makes to `write`, as soon as it is made: names relative to the output's folder.
  /// Those for which `has` gives a length are there from an interrupted run, and not made again.
  using WriteFile = std::function<void(const std::string& name, const std::string& bytes)>;
  using HasFile = std::function<std::optional<std::size_t>(const std::string& name)>;
  struct Door {
    WriteFile write;
    HasFile has;
  };
  Outcome run(const std::string& subject, const HeadAsset& head, RetargetFormat format,
              const Door& door) const;

  const ParameterTrack& track() const { return track_; }
  std::size_t vertex_count() const { return maker_.uv().size(); }

 private:
  void write_frames(const std::string& subject, const CompiledCascade& cascade, const NeutralSurface& neutral,
                    const Door& door) const;

  Deformation rig_;
  ParameterTrack track_;
  NeutralMaker maker_;
  SampledFields fields_;
};

}  // namespace phiz
