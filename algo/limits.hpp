// Every static size of the core, in one place: the pipeline owns arrays of exactly these
// lengths and never allocates.
#pragma once

namespace vergence {

inline constexpr int kMaxImageWidth = 1280;
inline constexpr int kMaxImageHeight = 1024;
inline constexpr int kMaxImagePixels = kMaxImageWidth * kMaxImageHeight;

inline constexpr int kPopulation = 20;                      // individuals, fixed by the method
inline constexpr int kGenes = 6;                            // x y z e1 e2 e3
inline constexpr int kGeneBits = 12;                        // bits a gene
inline constexpr int kChromosomeBits = kGenes * kGeneBits;  // 72

inline constexpr int kMaxBalls = 8;            // balls of a marker
inline constexpr int kMaxInnerSamples = 64;    // samples of a ball's disc S_in
inline constexpr int kMaxOuterSamples = 64;    // samples of a ball's ring S_out
inline constexpr int kMaxPhotoPoints = 4096;   // points of a photo-model, S_in and S_out together
inline constexpr int kMaxRefinePoints = 1024;  // points of S_in that refinement reads
inline constexpr int kMaxReliefPoints = 1024;  // points of a photo-model whose depth is learned
inline constexpr int kReliefNeighbours = 4;    // that a point's depth is tied to

inline constexpr int kMaxJoints = 7;           // joints of the arm
inline constexpr int kMaxArmSolutions = 8;     // joint vectors of one hand pose
inline constexpr int kMaxIkIterations = 1000;  // of iterative inverse kinematics

}  // namespace vergence
