// A cascade of one stump, its mirror image, and both as OpenCV's XML.
#include <ssjs/cascade/cascade_xml.hpp>

int main() {
  ssjs::HaarCascade cascade;
  cascade.window = {9, 4};
  cascade.features = {{{{{{0, 0, 9, 4}, -1}, {{8, 0, 1, 4}, 9}, {}}}, false}};
  cascade.stages = {{{{{{0, 0.1F, 0, -1}}, {-1, 1}}}, 0.5F}};
  const ssjs::HaarCascade mirror = ssjs::mirrored(cascade);
  const ssjs::HaarCascade read = ssjs::from_opencv_xml(ssjs::to_opencv_xml(mirror), "text");
  return read.features[0].rects[1].rect.x == 0 && ssjs::mirrored(read) == cascade ? 0 : 1;
}
