// gmsh -2 -format msh22 clip.geo
// a clip: two legs of 40 mm by 2 mm with a slot of 2 mm between them, in one piece with its back; the ends of the legs are round inside
h = 1; f = 0.006; g = 0.02; a = 0.05; b = 0.5;
Point(1) = {-3, -3, 0, 1}; Point(2) = {0, -3, 0, h}; Point(3) = {19.4, -3, 0, b}; Point(4) = {19.9, -3, 0, g}; Point(5) = {20, -3, 0, g};
Point(6) = {20.5, -3, 0, b}; Point(7) = {40, -3, 0, h}; Point(8) = {40, -2, 0, 0.3}; Point(9) = {39 + Sin(a), -2 + Cos(a), 0, f};
Point(10) = {39, -2, 0, h}; Point(11) = {38.98, -1, 0, f}; Point(12) = {38.5, -1, 0, b}; Point(13) = {0, -1, 0, 0.5};
Point(101) = {-3, 3, 0, 1}; Point(102) = {0, 3, 0, h}; Point(103) = {19.4, 3, 0, b}; Point(104) = {19.9, 3, 0, g}; Point(105) = {20, 3, 0, g};
Point(106) = {20.5, 3, 0, b}; Point(107) = {40, 3, 0, h}; Point(108) = {40, 2, 0, 0.3}; Point(109) = {39 + Sin(a), 2 - Cos(a), 0, f};
Point(110) = {39, 2, 0, h}; Point(111) = {38.98, 1, 0, f}; Point(112) = {38.5, 1, 0, b}; Point(113) = {0, 1, 0, 0.5};
Point(14) = {39, -1, 0, f}; Point(114) = {39, 1, 0, f};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8};
Circle(8) = {8, 10, 9}; Circle(9) = {9, 10, 14}; Line(10) = {14, 11}; Line(11) = {11, 12}; Line(12) = {12, 13};
Line(101) = {101, 102}; Line(102) = {102, 103}; Line(103) = {103, 104}; Line(104) = {104, 105}; Line(105) = {105, 106}; Line(106) = {106, 107}; Line(107) = {107, 108};
Circle(108) = {108, 110, 109}; Circle(109) = {109, 110, 114}; Line(110) = {114, 111}; Line(111) = {111, 112}; Line(112) = {112, 113};
Line(13) = {13, 113}; Line(14) = {1, 101};
Curve Loop(1) = {1:12, 13, -112, -111, -110, -109, -108, -107, -106, -105, -104, -103, -102, -101, -14}; Plane Surface(1) = {1};
Physical Curve("back") = {1, 13, 101, 14}; Physical Curve("lower") = {2:6}; Physical Curve("upper") = {102:106};
Physical Curve("lower end") = {8, 9}; Physical Curve("upper end") = {108, 109}; Physical Surface("clip") = {1};
