// Solid sphere centred at the origin. Lengths in metres.
SetFactory("OpenCASCADE");

DefineConstant[
  radius = {0.25, Name "Parameters/radius"},  // [m]
  size   = {0.05, Name "Parameters/size"}     // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

Sphere(1) = {0, 0, 0, radius};

Physical Volume("body") = {1};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });
