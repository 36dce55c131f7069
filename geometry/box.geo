// Solid box centred at the origin, edges along the axes. Lengths in metres.
SetFactory("OpenCASCADE");

DefineConstant[
  length = {1.0, Name "Parameters/length"},  // [m] along x
  width  = {1.0, Name "Parameters/width"},   // [m] along y
  height = {1.0, Name "Parameters/height"},  // [m] along z
  size   = {0.5, Name "Parameters/size"}     // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

Box(1) = {-length/2, -width/2, -height/2, length, width, height};

Physical Volume("body") = {1};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });
