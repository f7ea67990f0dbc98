// A quarter of a ball of radius 50 that is cut to a prism of side 30, with cells of size h around the origin, where it touches z = 0.
// gmsh -3 -setnumber h 0.8 -format mesh -o ball.mesh scripts/ball.geo
SetFactory("OpenCASCADE");
DefineConstant[ h = 0.8 ];
Sphere(1) = {0, 0, 50, 50};
Box(2) = {0, 0, 0, 30, 30, 30};
BooleanIntersection{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.25*max(0, sqrt(x*x + y*y + z*z) - 3.5)", h);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
